"""The files a translation leaves in the memory: NAME.IRD where the source has no error, NAME.ERR where it has (rho 3 releases L785-794)."""

import json
import zlib
from collections.abc import Iterable

from gateway.pure.languages.baps2.tree import Declared, Program
from gateway.pure.languages.base.faults import Faults

FORM = 1  # of the IRD file; that of the old controller is binary


def ird_of(program: Program, source: str, age: int) -> str:
    """The IRD file of a translated source.  `age`: greater than that of all before."""
    exports = [each.name for each in program.main.declarations if isinstance(each, Declared) and each.public]
    return json.dumps({"axisgate": FORM, "program": program.main.name, "source": digest(source), "age": age, "exports": exports}) + "\n"


def err_of(faults: Faults) -> str:
    """The ERR file: one line a fault."""
    return "".join(f"{each}\n" for each in faults)


def digest(source: str) -> str:
    """What ties an IRD to its source."""
    data = source.encode()
    return f"{zlib.crc32(data):08x}-{len(data)}"


def age_of(ird: str | None, source: str | None) -> int | None:
    """The age in an IRD file; None where it is none of axisgate's, or the source has changed since."""
    try:
        data = json.loads(ird or "")
    except ValueError:
        return None
    if not isinstance(data, dict) or data.get("axisgate") != FORM or source is None or data.get("source") != digest(source):
        return None
    age = data.get("age")
    return age if isinstance(age, int) else None


def next_age(irds: Iterable[str]) -> int:
    """Return the age of the next translation, after those of these IRD files."""
    found = []
    for text in irds:
        try:
            data = json.loads(text)
        except ValueError:
            continue
        if isinstance(data, dict) and isinstance(data.get("age"), int):
            found.append(int(data["age"]))
    return max(found, default=0) + 1
