"""Backup of a cell as one ZIP file: the cell, the files it names, its DAT files, its retained data, a manifest with their sums (AX-426)."""

import contextlib
import hashlib
import importlib.metadata
import json
import os
import pathlib
import shutil
import sqlite3
import tempfile
import tomllib
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.integrated_plc import kept_of
from gateway.assembly.program_memory import program_folders
from gateway.cell_file.load import load_cell
from gateway.files.find import read_text
from gateway.files.safe_file import put_in_place
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cell.web import Web
from gateway.runtime.clock import wall
from gateway.runtime.kept_aside import kept_aside
from gateway.runtime.page_data import data_file
from gateway.runtime.retained import writer as retain
from gateway.runtime.retained.store import RetainError, open_file

FORMAT = 1
MANIFEST = "manifest.json"
MOST_BYTES = 512 << 20  # all files of a backup together
RETAINED = "retained data"
MARKERS = "markers of the PLC"
STATE_FOLDERS = ("retain", "zero", "web")  # beside the cell file: what of them belongs into a backup is copied in its own way
KEY, USERS = "key", "users of the page"
SECRETS = (KEY, USERS)
SECRET_KEYS = ("key", "tls_key", "password_file")  # of a cell file: they name files with secrets
SEEN_BYTES = 1 << 16  # of a file that may hold a private key


class BackupError(Exception):
    """The file is not a backup, or does not fit here; the message names the reason."""


@dataclass(frozen=True, slots=True)
class Part:
    """One file of a backup; `name`: relative to the folder of the cell."""

    name: str
    role: str  # cell file | named by the cell | retained data | markers of the PLC | zeros
    size: int
    sha256: str


@dataclass(frozen=True, slots=True)
class Manifest:
    """Description inside a backup."""

    version: str  # of axisgate
    wall: str
    cell: str  # name of the cell file
    title: str
    parts: tuple[Part, ...]
    left_out: tuple[str, ...] = ()  # files the cell names that lie elsewhere
    withheld: tuple[str, ...] = ()  # keys, passwords, users of the page: only included in a backup on request


@dataclass(frozen=True, slots=True)
class Step:
    """Result of restoring one file: new | same | replaced."""

    part: Part
    what: str


def make(cell: Cell, target: pathlib.Path, *, secrets: bool = False) -> Manifest:
    """Writes the backup; the cell may keep running.  secrets: with keys and users, readable by its owner alone.  OSError."""
    with tempfile.TemporaryDirectory(prefix="axisgate-") as folder:
        found, left_out = sources(cell, pathlib.Path(folder))
        own = target.resolve()  # in a memory that is the folder of the cell: an earlier backup of this name
        found = {name: source for name, source in found.items() if pathlib.Path(cell.file).resolve().parent / name != own}
        withheld = () if secrets else tuple(name for name, (role, _) in found.items() if role in SECRETS)
        found = {name: source for name, source in found.items() if name not in withheld}
        parts = tuple(Part(name, role, path.stat().st_size, sum_of(path)) for name, (role, path) in found.items())
        file = pathlib.Path(cell.file)
        manifest = Manifest(version(), wall(), file.name, cell.cell.name, parts, tuple(left_out), withheld)
        partial = target.with_name(target.name + ".part")
        partial.unlink(missing_ok=True)
        fd = os.open(partial, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600 if secrets else 0o666)
        with os.fdopen(fd, "w+b") as raw, zipfile.ZipFile(raw, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(MANIFEST, json.dumps(_as_json(manifest), indent=1, ensure_ascii=False))
            for name, (_, path) in found.items():
                archive.write(path, name)
    try:
        read(partial)  # a file that cannot be read back is not a backup
        put_in_place(partial, target)
    finally:
        partial.unlink(missing_ok=True)
    return manifest


def sources(cell: Cell, scratch: pathlib.Path) -> tuple[dict[str, tuple[str, pathlib.Path]], list[str]]:
    """Name in the backup -> (role, file), and the files of the cell in other folders."""
    file = pathlib.Path(cell.file).resolve()
    found = {file.name: ("cell file", file)}
    left_out = []
    for path in named_by(file):
        if path.is_relative_to(file.parent):
            found.setdefault(str(path.relative_to(file.parent)), (_role(cell, path), path))
        else:
            left_out.append(str(path))
    found |= _programs(cell, scratch, left_out)
    users = data_file(cell, cell.web or Web(), simulated=False)
    if users.exists():
        found = {name: source for name, source in found.items() if source[0] != USERS}  # its log files: the copy needs none
        copied_as_is(users, scratch / "users.sqlite")
        found[str(users.relative_to(file.parent)) if users.is_relative_to(file.parent) else f"web/{users.name}"] = (
            USERS,
            scratch / "users.sqlite",
        )
    kept = retain.path_of(cell)
    if kept.exists():
        copied(kept, scratch / "retained.sqlite")
        found[f"retain/{file.stem}.sqlite"] = (RETAINED, scratch / "retained.sqlite")
    if (markers := kept_of(cell)) is not None and markers.exists():
        shutil.copy2(markers, scratch / "markers.plc")  # a running PLC may replace it
        found[f"retain/{file.stem}.plc"] = (MARKERS, scratch / "markers.plc")
    for path in (zeros.path_of(cell), zeros.path_of(cell).with_suffix(".enable.jsonl")):
        if path.exists():
            found[f"zero/{path.name}"] = ("zeros", path)
    return found, left_out


def _programs(cell: Cell, scratch: pathlib.Path, left_out: list[str]) -> dict[str, tuple[str, pathlib.Path]]:
    """Copies of all programs, because a running one may replace its files; folders elsewhere are added to `left_out`."""
    found: dict[str, tuple[str, pathlib.Path]] = {}
    home = pathlib.Path(cell.file).resolve().parent
    for folder in program_folders(cell):
        if not folder.is_relative_to(home):
            left_out.extend([str(folder)] if str(folder) not in left_out else [])
            continue
        for path in files_below(folder):
            inside = path.relative_to(home)
            if str(inside) in found or (folder == home and inside.parts[0] in STATE_FOLDERS):
                continue
            source = scratch / "programs" / inside
            source.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, source)
            found[str(inside)] = ("cell file" if path == pathlib.Path(cell.file).resolve() else _role(cell, path), source)
    return found


def named_by(file: pathlib.Path) -> list[pathlib.Path]:
    """Files any value of the cell file names, and those of folders it names; packaged ones come with axisgate."""
    found: dict[pathlib.Path, None] = {}
    for text in _strings(tomllib.loads(read_text(file))):
        with contextlib.suppress(OSError, ValueError):  # values that are not file names at all
            path = (file.parent / text).resolve()
            if text.strip("./") and path.is_file() and path != file:
                found[path] = None
            elif text.strip("./") and path.is_dir() and path.is_relative_to(file.parent) and path != file.parent:
                found.update(dict.fromkeys(sorted(each for each in path.iterdir() if each.is_file())))
    return [path for path in found if not str(path).startswith(("/dev/", "/proc/", "/sys/"))]


def files_below(folder: pathlib.Path) -> list[pathlib.Path]:
    """Return all files of a folder of programs, without those that are being written."""
    found = (pathlib.Path(at, name) for at, _, names in os.walk(folder) for name in names)
    return sorted(path for path in found if path.is_file() and not (path.name.startswith(".") and path.name.endswith(".part")))


def _role(cell: Cell, path: pathlib.Path) -> str:
    """Role of a file that the cell names."""
    if path.name.startswith(data_file(cell, cell.web or Web(), simulated=False).name):
        return USERS
    words = tomllib.loads(read_text(pathlib.Path(cell.file)))
    named = {(pathlib.Path(cell.file).resolve().parent / text).resolve() for text in _under(words, SECRET_KEYS)}
    with contextlib.suppress(OSError), path.open("rb") as file:
        if path in named or b"PRIVATE KEY-----" in file.read(SEEN_BYTES):
            return KEY
    return "named by the cell"


def _under(value: object, keys: tuple[str, ...]) -> Iterator[str]:
    """Texts under one of these keys."""
    if isinstance(value, dict):
        for key, each in value.items():
            if key in keys and isinstance(each, str):
                yield each
            else:
                yield from _under(each, keys)
    elif isinstance(value, list):
        for each in value:
            yield from _under(each, keys)


def copied(source: pathlib.Path, target: pathlib.Path) -> None:
    """A consistent copy of retained data that may be in use.  OSError."""
    copied_as_is(source, target)
    open_file(target, repair=False).file.close()


def copied_as_is(source: pathlib.Path, target: pathlib.Path) -> None:
    """A copy of any SQLite file.  OSError."""
    try:
        closing, connect = contextlib.closing, sqlite3.connect
        with closing(connect(f"file:{source}?mode=ro", uri=True)) as here, closing(connect(target)) as there:
            here.backup(there)
    except sqlite3.Error as error:
        raise RetainError(f"{source}: cannot be read: {error}") from error


# ---- reading one back


def read(path: pathlib.Path) -> Manifest:
    """The manifest of a backup whose files are all there and unchanged.  BackupError; OSError."""
    try:
        with zipfile.ZipFile(path) as archive:
            manifest = _manifest(json.loads(archive.read(MANIFEST)))
            listed = sorted([MANIFEST, *(part.name for part in manifest.parts)])
            if sorted(archive.namelist()) != listed:
                raise BackupError(f"{path}: contains {', '.join(sorted(archive.namelist()))}; its manifest lists {', '.join(listed)}")
            if sum(part.size for part in manifest.parts) > MOST_BYTES:
                raise BackupError(f"{path}: more than {MOST_BYTES >> 20} MiB")
            for part in manifest.parts:
                _judge(path, archive, part)
    except (zipfile.BadZipFile, KeyError, ValueError, EOFError, NotImplementedError, RuntimeError) as error:
        raise BackupError(f"{path}: is not a backup of axisgate: {error}") from error
    return manifest


def steps(manifest: Manifest, folder: pathlib.Path) -> list[Step]:
    """The steps of restoring into `folder`."""
    found = []
    for part in manifest.parts:
        there = folder / part.name
        same = there.is_file() and there.stat().st_size == part.size and sum_of(there) == part.sha256
        found.append(Step(part, "same" if same else "replaced" if there.exists() else "new"))
    return found


def others(manifest: Manifest, folder: pathlib.Path) -> list[str]:
    """Files in the folders of programs of a restored cell that the backup does not have: they stay, and act."""
    with stand_ins(folder, manifest):
        cell = load_cell(str(folder / manifest.cell))
    home, known = folder.resolve(), {part.name for part in manifest.parts}
    there = (path for folder in program_folders(cell) if folder != home and folder.is_relative_to(home) for path in files_below(folder))
    names = {str(path.relative_to(home)) for path in there if ".before-" not in path.name}
    return sorted(names - known - set(manifest.withheld))


def try_out(path: pathlib.Path, manifest: Manifest) -> None:
    """Unpacks it elsewhere and checks the cell.  BackupError."""
    with tempfile.TemporaryDirectory(prefix="axisgate-") as scratch, zipfile.ZipFile(path) as archive:
        archive.extractall(scratch, [part.name for part in manifest.parts])
        check(pathlib.Path(scratch), manifest)


def restore(path: pathlib.Path, manifest: Manifest, folder: pathlib.Path) -> list[pathlib.Path]:
    """Put the files in place; keep the present files under new names, which are returned.  BackupError: nothing was changed.

    Everything is first unpacked next to its place and checked, so a fault changes nothing; then each file is replaced in one step.
    """
    folder.mkdir(parents=True, exist_ok=True)
    kept: list[pathlib.Path] = []
    with tempfile.TemporaryDirectory(prefix=".restore-", dir=folder) as scratch:
        unpacked = pathlib.Path(scratch)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(unpacked, [part.name for part in manifest.parts])
        check(unpacked, manifest)
        for step in steps(manifest, folder):
            place = folder / step.part.name
            place.parent.mkdir(parents=True, exist_ok=True)
            if step.what == "same":
                continue
            if step.what == "replaced":
                kept.append(_put_by(place, step.part))
            if step.part.role in (RETAINED, USERS):
                for log in ("-wal", "-shm"):
                    place.with_name(place.name + log).unlink(missing_ok=True)
            if step.part.role in SECRETS:
                (unpacked / step.part.name).chmod(0o600)
            put_in_place(unpacked / step.part.name, place)
    return kept


def check(folder: pathlib.Path, manifest: Manifest) -> Cell:
    """Check the unpacked cell.  BackupError: this version of axisgate does not accept it."""
    if _number(manifest.version) > _number(version()):
        raise BackupError(f"made by axisgate {manifest.version}; this is {version()}, which is older")
    try:
        for part in manifest.parts:
            if part.role == RETAINED:
                open_file(folder / part.name, repair=False).file.close()
        with stand_ins(folder, manifest):
            return load_cell(str(folder / manifest.cell))
    except CellFaults as found:
        raise BackupError("\n".join(["its cell has faults here:", *map(str, found.faults)])) from found
    except RetainError as error:
        raise BackupError(str(error)) from error


@contextlib.contextmanager
def stand_ins(folder: pathlib.Path, manifest: Manifest) -> Iterator[None]:
    """Empty files in place of withheld keys, because the cell checks that they exist."""
    made = [place for name in manifest.withheld if not (place := folder / name).exists()]
    for place in made:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.touch(0o600)
    try:
        yield
    finally:
        for place in made:
            place.unlink(missing_ok=True)


def version() -> str:
    """Version of this axisgate."""
    return importlib.metadata.version("axisgate")


def sum_of(path: pathlib.Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _put_by(place: pathlib.Path, part: Part) -> pathlib.Path:
    old = kept_aside(place)
    if part.role == RETAINED:
        with contextlib.suppress(OSError, sqlite3.Error):
            copied(place, old)  # including its log
            return old
    shutil.copy2(place, old)
    return old


def _judge(path: pathlib.Path, archive: zipfile.ZipFile, part: Part) -> None:
    name = pathlib.PurePosixPath(part.name)
    if name.is_absolute() or ".." in name.parts or "\\" in part.name or archive.getinfo(part.name).file_size != part.size:
        raise BackupError(f"{path}: {part.name}: name or size is not what a backup has")
    if hashlib.sha256(archive.read(part.name)).hexdigest() != part.sha256:
        raise BackupError(f"{path}: {part.name} is not what was saved (its sum differs)")


def _manifest(raw: dict[str, object]) -> Manifest:
    if raw.get("format") != FORMAT:
        raise BackupError(f"format {raw.get('format')!r} of the backup; {FORMAT} is known")
    parts = raw["parts"]
    if not isinstance(parts, list):
        raise ValueError("parts of the manifest")
    made = tuple(Part(str(p["name"]), str(p["role"]), int(p["size"]), str(p["sha256"])) for p in parts)
    left_out, withheld = (tuple(map(str, each)) if isinstance(each := raw.get(key), list) else () for key in ("left_out", "withheld"))
    if any(pathlib.PurePosixPath(name).is_absolute() or ".." in pathlib.PurePosixPath(name).parts for name in withheld):
        raise ValueError("withheld of the manifest")
    return Manifest(str(raw["version"]), str(raw["wall"]), str(raw["cell"]), str(raw["title"]), made, left_out, withheld)


def _as_json(manifest: Manifest) -> dict[str, object]:
    parts = [{"name": p.name, "role": p.role, "size": p.size, "sha256": p.sha256} for p in manifest.parts]
    head = {"format": FORMAT, "version": manifest.version, "wall": manifest.wall, "cell": manifest.cell, "title": manifest.title}
    return {**head, "parts": parts, "left_out": list(manifest.left_out), "withheld": list(manifest.withheld)}


def _number(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".")[:3] if part.isdigit())


def _strings(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for each in value.values():
            yield from _strings(each)
    elif isinstance(value, list):
        for each in value:
            yield from _strings(each)
