"""`axisgate program put|get|compile`: the files of a memory."""

import argparse
import json
import pathlib
import sys

from gateway.assembly.program_memory import memory_folder
from gateway.files.program_memory import baps2_words, folder_memory
from gateway.files.safe_file import write_whole
from gateway.pure.languages.baps2.compiling import compile_program
from gateway.pure.languages.baps2.library import Library
from gateway.runtime.exit_codes import Exit
from gateway.tools.cell_argument import load
from gateway.tools.command_support import USAGE
from gateway.tools.usage_language import baps2_text, complain, fault_text

OF_FILES = ("put", "get", "compile")


class FileFault(Exception):
    """One sentence."""


def add_files_to(tools: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Their options."""
    put = tools.add_parser("put", help="copy files into the memory of a cell; a running cell uses them from the next start of a program")
    put.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    put.add_argument("files", nargs="+", metavar="FILE", type=pathlib.Path)
    put.add_argument("--force", action="store_true", help="replace existing files")
    get = tools.add_parser("get", help="copy files out of the memory of a cell")
    get.add_argument("cell", metavar="CELL")
    get.add_argument("names", nargs="*", metavar="NAME", help="file or program (default: all)")
    get.add_argument(
        "--to", metavar="FOLDER", type=pathlib.Path, default=pathlib.Path(), help="target folder; existing files are not replaced"
    )
    translate = tools.add_parser("compile", help="translate programs: write NAME.IRD, or NAME.ERR with the faults")
    translate.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="the memory folder")
    translate.add_argument("programs", nargs="+", metavar="PROGRAM")
    for each in (put, get, translate):
        each.add_argument("--json", action="store_true", help="a JSON list of what was written")


def run_on_files(options: argparse.Namespace) -> int:
    """One of them."""
    try:
        return _compile(options) if options.tool == "compile" else _with_cell(options)
    except FileFault as fault:
        complain("program", fault)
        return Exit.INVALID
    except OSError as error:
        complain("program", f"{error.filename}: {error.strerror}")
        return Exit.INVALID


def _with_cell(options: argparse.Namespace) -> int:
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    folder = memory_folder(cell)
    if folder is None:
        complain("program", f"{options.cell}: [controller] names no memory")
        return USAGE
    return _put(folder, options) if options.tool == "put" else _get(folder, options)


def _put(folder: pathlib.Path, options: argparse.Namespace) -> int:
    """All of them or none."""
    there = {path.name.upper(): path for path in folder.iterdir() if path.is_file()}
    wanted = [(there.get(path.name.upper(), folder / path.name.upper()), path.read_bytes()) for path in options.files]
    double = {target.name for target, _ in wanted if sum(other.name == target.name for other, _ in wanted) > 1}
    if double:
        raise FileFault(f"{', '.join(sorted(double))} is given twice")
    held = [target.name for target, data in wanted if target.exists() and target.read_bytes() != data]
    if held and not options.force:
        raise FileFault(f"{folder} has {', '.join(held)} already; --force replaces it, nothing was written")
    for target, data in wanted:
        write_whole(target, data)
    _print([str(target) for target, _ in wanted], options)
    return _checked(folder, [target.stem.upper() for target, _ in wanted if target.suffix.upper() == ".QLL"])


def _checked(folder: pathlib.Path, programs: list[str]) -> int:
    """Faults of the stored program: it is kept, as on the control, but cannot run."""
    library, errors = Library(baps2_words(), folder_memory(folder)), 0
    for name in programs:
        _, faults = library.unit(name)
        for fault in faults:
            print(fault_text(fault, baps2_text), file=sys.stderr)
        errors += faults.errors
    return Exit.FINDING if errors else Exit.OK


def _get(folder: pathlib.Path, options: argparse.Namespace) -> int:
    files = sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    names = [name.upper() for name in options.names]
    found = [path for path in files if not names or {path.name.upper(), path.stem.upper()} & set(names)]
    known = {part for path in files for part in (path.name.upper(), path.stem.upper())}
    if absent := [name for name in names if name not in known]:
        raise FileFault(f"{folder} has no {', '.join(absent)}; it has {', '.join(path.name for path in files) or 'nothing'}")
    if held := [path.name for path in found if (options.to / path.name).exists()]:
        raise FileFault(f"{options.to} has {', '.join(held)} already; name an empty folder with --to")
    for path in found:
        write_whole(options.to / path.name, path.read_bytes())
    _print([str(options.to / path.name) for path in found], options)
    return Exit.OK


def _compile(options: argparse.Namespace) -> int:
    memory = folder_memory(options.folder)
    library, written, errors = Library(baps2_words(), memory), [], 0
    names = [name.upper().removesuffix(".QLL") for name in options.programs]
    if absent := [name for name in names if not library.has(name)]:
        raise FileFault(f"{options.folder} has no source of {', '.join(absent)}")
    sources = {path.stem.upper(): path for path in options.folder.iterdir() if path.suffix.upper() == ".QLL"}
    for name in names:
        done = compile_program(library, memory, name)
        put, dropped = (sources[name].with_suffix(pathlib.PurePath(each).suffix) for each in (done.file, done.dropped))
        write_whole(put, memory.files[done.file])
        dropped.unlink(missing_ok=True)
        errors += done.faults.errors
        written.append(str(put))
        for fault in done.faults:
            print(fault_text(fault, baps2_text), file=sys.stderr)
    _print(written, options)
    return Exit.FINDING if errors else Exit.OK


def _print(written: list[str], options: argparse.Namespace) -> None:
    print(json.dumps(written, indent=1) if options.json else "\n".join(written))
