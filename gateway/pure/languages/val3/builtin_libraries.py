"""Instructions on libraries and named data.  Source: VAL 3 reference 6.7, L4010-4112; getData L1207-1244."""

import re
from collections.abc import Generator

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.arrays import Local, copy_values
from gateway.pure.languages.val3.disk import PathFault, application_of, resolve
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.numbers import Place
from gateway.pure.languages.val3.saving import save
from gateway.pure.languages.val3.sealed import SealFault, library_of
from gateway.pure.languages.val3.values import Structure, copied

Waiting = Generator[Ns | None, None, object]
DATUM = re.compile(r"^(?:(\w+):)?(\w+)(?:\[(-?\d+\.?\d*)\])?$", re.ASCII)


def _turn(own: Instance) -> Waiting:
    if not own.machine.current_is_synchronous:
        yield own.machine.now
    return None


def f_lib_load(own: Instance, identifier: str, path: str, password: str | None = None) -> Waiting:
    """Codes of L3970-4006; no run-time error."""
    yield from _turn(own)
    try:
        folder, name = library_of(own.machine.disk, path, own.loaded.app.path, password)
    except (PathFault, SealFault) as fault:
        own.machine.note(f"{path}: {fault}", "VAL3")
        return float(fault.code)
    return float(own.machine.loads(own, identifier, folder, name, path))


def f_lib_save(own: Instance, path: str | None = None) -> Waiting:
    """Of the calling application."""
    yield from _turn(own)
    return float(_save(own, own, path))


def f_lib_save_of(own: Instance, identifier: str, path: str | None = None) -> Waiting:
    """10 where nothing is loaded."""
    yield from _turn(own)
    found = own.libraries.get(identifier)
    return 10.0 if found is None else float(_save(own, found, path))


def _save(own: Instance, what: Instance, path: str | None) -> int:
    try:
        if path is None:
            folder, name = what.loaded.app.path, what.loaded.app.name
        else:
            folder, name = application_of(path, own.loaded.app.path)
    except PathFault as fault:
        return fault.code
    if own.machine.disk.secret(what.loaded.app.path):
        return 40  # nothing of an encrypted library is written (AX-992)
    project = f"{folder}/{name}.pjx" if folder else f"{name}.pjx"
    if own.machine.disk.read(project) is not None and path is not None:
        return 31
    for file, data in save(what, folder, name):
        own.machine.disk.write(file, data)
    own.machine.loader.forget(folder, name)
    return 0


def f_lib_delete(own: Instance, path: str) -> Waiting:
    """0 also where there is none."""
    yield from _turn(own)
    try:
        folder, name = application_of(path, own.loaded.app.path)
    except PathFault as fault:
        return float(fault.code)
    own.machine.disk.delete(folder)
    own.machine.loader.forget(folder, name)
    return 0.0


def f_lib_path(own: Instance) -> str:
    """Of the calling application."""
    return own.path


def f_lib_path_of(own: Instance, identifier: str) -> str:
    """ "" where nothing is loaded."""
    found = own.libraries.get(identifier)
    return "" if found is None else found.path


def f_lib_list(own: Instance, path: str, contents: Place) -> Waiting:
    """false: the array is too small; a global one grows."""
    yield from _turn(own)
    array, start = contents
    array[start:] = [""] * (len(array) - start)
    try:
        folder = "" if path.strip().rstrip("/:").lower() in ("", "disk") else resolve(path, own.loaded.app.path)
    except PathFault:
        return False
    entries = own.machine.disk.entries(folder)
    if not isinstance(contents, Local) and len(entries) > len(array) - start:
        array.extend("" for _ in range(len(entries) - (len(array) - start)))
    for at, entry in enumerate(entries[: len(array) - start]):
        array[start + at] = entry
    return len(entries) <= len(array) - start


def f_lib_exist(own: Instance, identifier: str, symbol: str) -> bool:
    """Return whether the symbol exists: public data, or programs with () after the name."""
    found = own.libraries.get(identifier)
    if found is None:
        return False
    name = symbol.split("(", maxsplit=1)[0]
    if "(" in symbol:
        program = found.loaded.app.programs.get(name)
        return program is not None and program.public
    declared = found.loaded.app.data.get(name)
    return declared is not None and declared.public


def f_get_data(own: Instance, name: str, target: list[object], place: int, single: bool, kind: str) -> float:
    """The number of values copied; -1 .. -4."""
    match = DATUM.match(name.strip())
    if match is None:
        return -1.0
    library, datum, index = match.groups()
    home: Instance | None = own
    if library is not None:
        if library not in own.libraries:
            return -2.0
        home = own.libraries[library]
        if home is None:
            return -1.0
    assert home is not None
    declared = home.loaded.app.data.get(datum)
    if declared is None or (home is not own and not declared.public):
        return -1.0
    own_kind = declared.type if isinstance(declared.type, str) else declared.type.path
    if own_kind != kind:
        return -4.0
    source = home.data[datum]
    if not isinstance(source, list):
        return -4.0
    start = 0 if index is None else int(float(index) + 0.5)
    if not 0 <= start < len(source) or (index or "").startswith("-"):
        return -3.0
    if single:
        held = target[place]
        if isinstance(held, Structure):
            held.set(copied(source[start]))
        else:
            target[place] = source[start]
        return 1.0
    if not isinstance(place, int) or place >= len(target):
        return -3.0
    return float(copy_values(source, start, target, place) if index is None else copy_values([source[start]], 0, target, place))
