"""One translation in the memory: NAME.IRD where the source has no error, NAME.ERR with its faults where it has, and never both."""

from dataclasses import dataclass

from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory, decoded
from gateway.pure.languages.baps2.translated import err_of, ird_of, next_age
from gateway.pure.languages.base.faults import Faults


@dataclass(frozen=True, slots=True)
class Compiled:
    """What became of it.  file: NAME.IRD or NAME.ERR, in the memory now; dropped: the other of the two."""

    file: str
    dropped: str
    faults: Faults


def compile_program(library: Library, memory: Memory, name: str) -> Compiled:
    """Translates NAME.QLL of the memory, as it is there now; `name`: in upper case, without extension."""
    library.forget(name)
    _, faults = library.unit(name)
    program = library.tree(name)
    put, dropped = f"{name}.IRD", f"{name}.ERR"
    if program is None or faults.errors:
        put, dropped = dropped, put
        text = err_of(faults)
    else:
        ages = (decoded(data) for file, data in memory.files.items() if file.endswith(".IRD"))
        text = ird_of(program, memory.text(f"{name}.QLL") or "", next_age(ages))
        memory.newest(name)
    memory.files[put] = text.encode()
    memory.files.pop(dropped, None)
    return Compiled(put, dropped, faults)
