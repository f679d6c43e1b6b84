"""Record every input of a running cell to a file for `axisgate replay`."""

import argparse
import json
import pathlib
import sys
import tempfile
import time
from typing import Any

from gateway.assembly.drive_buses import DRIVE_PROTOCOLS
from gateway.assembly.run import known_zeros, slug_of
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.recording.backup import make
from gateway.recording.file import RecordError, Writer
from gateway.recording.recorder import Recorder, RecorderError, Rings, attached, head_of, status_of
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE, interruptible
from gateway.tools.usage_language import complain, result_text

EXAMPLES = """examples:
  axisgate record cell.toml -o monday.axrec                 until Ctrl-C; the cell runs in another terminal
  axisgate record --name line2 --for 3600 -o hour.axrec     a run by its name, for an hour
  axisgate record cell.toml -o monday.axrec                 again: an ended recorder continues its file
then: axisgate replay monday.axrec --diff
exit code: 0 done, 1 something was lost (named in the file), 2 command line or file, 3 no such run, or it is being recorded already"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate record", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", nargs="?", help="cell file, or the name of a shipped one")
    parser.add_argument("--name", "--slug", metavar="NAME", help="name of the run, if it differs from the file")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="FILE")
    parser.add_argument("--for", dest="seconds", type=float, metavar="S", help="seconds (default: until Ctrl-C)")
    parser.add_argument("--json", action="store_true", help="what was kept as JSON")
    options = parser.parse_args(argv)
    if options.cell is None and options.name is None:
        parser.error("name the run with CELL or --name NAME")
    if options.seconds is not None and options.seconds <= 0:
        parser.error(f"--for {options.seconds:g}: more than 0 s")
    try:
        return _record(options)
    except RecordError as error:
        return _said(error, USAGE)
    except RecorderError as error:
        return _said(error, ENVIRONMENT)
    except OSError as error:
        return _said(f"{error.filename}: {error.strerror}", ENVIRONMENT)


def _said(error: object, code: int) -> int:
    complain("record", error)
    return code


def _record(options: argparse.Namespace) -> int:
    run = options.name
    if run is None:
        named = load(options.cell)
        if isinstance(named, int):
            return named
        run = slug_of(named)
    with attached(run) as rings, interruptible() as pressed:
        status = status_of(run)
        try:
            cell = load_cell(str(status["file"]))
        except CellFaults as faults:
            return _said(f"the file of the run has been changed and is no longer a valid cell: {faults.faults[0]}", USAGE)
        writer = _writer(options.output, status, cell, rings)
        recorder = Recorder(rings, writer)
        until = time.monotonic() + options.seconds if options.seconds else None
        recorder.run(lambda: pressed() or (until is not None and time.monotonic() >= until), Progress(options.output, writer))
        writer.end({"cycles": recorder.counts.cycles, "outputs_lost": recorder.counts.outputs_lost})
    return _report(options, recorder, writer)


def _writer(path: pathlib.Path, status: dict[str, Any], cell: Cell, rings: Rings) -> Writer:
    """The head of the file: the cell with its files and their checksums, the content of its store, its zeros."""
    with tempfile.TemporaryDirectory(prefix="axisgate-record-") as folder:
        zipped = pathlib.Path(folder, "cell.zip")
        manifest = make(cell, zipped)
        head = head_of(
            status,
            rings,
            sha256=next(part.sha256 for part in manifest.parts if part.role == "cell file"),
            zeros=known_zeros(cell),
            buses=[bus.name for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS],
            left_out=manifest.left_out,
        )
        return Writer(path, head, zipped.read_bytes())


def _report(options: argparse.Namespace, recorder: Recorder, writer: Writer) -> int:
    counts = recorder.counts
    found = {
        "file": str(options.output),
        "cycles": counts.cycles,
        "bytes": writer.bytes,
        "resumed": writer.resumed,
        "lost": counts.lost,
        "outputs_lost": counts.outputs_lost,
    }
    if options.json:
        print(json.dumps(found))
    else:
        for entry in counts.lost:
            print(result_text(f"lost after cycle {entry['after_cycle']}: {entry['why']}"))
        ended = f"{options.output}: {counts.cycles} cycles, {writer.bytes} bytes.  next: axisgate replay {options.output} --diff"
        print(result_text(ended))
    return FINDING if counts.lost or not counts.cycles else DONE


class Progress:
    """One line on a terminal, none in a pipe."""

    def __init__(self, path: pathlib.Path, writer: Writer) -> None:
        self._path, self._writer = path, writer

    def __call__(self, cycles: int) -> None:
        if sys.stderr.isatty():
            words = f"{cycles} cycles" if cycles else "waiting until nothing moves: a recording begins at rest"
            print(f"\r{self._path}: {words}, {self._writer.bytes} bytes  ", end="", file=sys.stderr, flush=True)
