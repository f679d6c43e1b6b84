"""Folder of all data that outlive a run: zeros, last places, confirmations, retained data, users of the page, the journal.

$AXISGATE_STATE names one folder for all of it; without it the state of a cell is next to its file.  State already next to the file (an
earlier run, a restored backup) has priority over the folder.  A shipped cell and one in a read-only folder can use only the runtime folder,
which a restart of the computer empties: `axisgate run` reports it.
"""

import glob
import hashlib
import os
import pathlib

from drivers.ports.base import PortError, runtime_dir
from gateway.files.find import PACKAGED

VARIABLE = "AXISGATE_STATE"


def configured() -> pathlib.Path | None:
    """The folder $AXISGATE_STATE names."""
    named = os.environ.get(VARIABLE)
    return pathlib.Path(named).absolute() if named else None


def usable() -> None:
    """Makes the configured folder.  PortError: it cannot be written, and a run must not find that out later."""
    folder = configured()
    if folder is None:
        return
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise PortError(f"{VARIABLE}={folder}: cannot be made ({error.strerror}); name a folder this user may write to") from error
    if not os.access(folder, os.W_OK):
        raise PortError(f"{VARIABLE}={folder}: cannot be written by this user; name another folder or change its owner")


def place(cell: str, kind: str, name: str) -> pathlib.Path:
    """The file `name` of a kind (zero, retain, web) that belongs to this cell file."""
    file = pathlib.Path(cell).resolve()
    beside, state = file.parent / kind, configured()
    if _stays(file) and (state is None or any(beside.glob(f"{glob.escape(file.stem)}.*"))):
        return beside / name
    if state is not None:
        same_name_elsewhere = hashlib.sha256(str(file).encode()).hexdigest()[:8]  # another cell.toml must not get these zeros
        return state / f"{file.stem}-{same_name_elsewhere}" / kind / name
    return runtime_dir() / kind / name


def journal(folder: pathlib.Path, slug: str) -> pathlib.Path:
    """The journal of a run; folder: its own in the runtime folder."""
    state = configured()
    if state is None:
        return folder / "journal.jsonl"
    return state / "journal" / f"{slug}.jsonl"


def warning(cell: str, *, simulated: bool) -> str:
    """Message of `run` about state that does not stay; empty: all of it does."""
    if configured() is not None or simulated:
        return ""
    few = _stays(pathlib.Path(cell).resolve())
    what = "the journal lies" if few else "the journal, zeros, last places, retained data and users of the page lie"
    folder = runtime_dir()
    return f"state: {what} in {folder}, which may be empty after a restart of the computer; set {VARIABLE} to a folder that stays"


def _stays(file: pathlib.Path) -> bool:
    return not file.is_relative_to(PACKAGED) and os.access(file.parent, os.W_OK)
