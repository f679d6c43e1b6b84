"""MOVE_FILE in the text form: `read_begin FILE 80`, `move_file FILE base=1 modulo=0,0`, `close FILE`.

Source: rho 3 Releases part 2 (TO05), sections 5.2, 5.3 (L7078-7212).
"""

from dataclasses import dataclass, field

from motion.files.bnr import HEADER, INTERPOLATION
from motion.program.blocks import FileCall
from motion.program.text.words import Fault, name, number, one
from motion.program.text.words import keys as keys_of

HEADS = ("read_begin", "move_file", "close")
BIG = 1e6


@dataclass(slots=True)
class OpenFiles:
    """What a text has opened so far: name -> read marker."""

    offsets: dict[str, int] = field(default_factory=dict)

    def read_begin(self, rest: list[str]) -> None:
        """FILE and the offset of its data, 80 when left out."""
        if not 1 <= len(rest) <= 2:
            raise Fault("read_begin", "the name of a BNR file and the offset of its first point: read_begin curve.bnr 80")
        offset = number("read_begin", rest[1], 0, 2**31 - 1, "") if len(rest) == 2 else HEADER
        if offset != int(offset):
            raise Fault("read_begin", f"{offset:g}: an offset is a whole number of bytes")
        self.offsets[name("read_begin", rest[0])] = int(offset)

    def close(self, rest: list[str]) -> None:
        """FILE; without effect on one that is not open."""
        self.offsets.pop(name("close", one("close", rest)), None)

    def call(self, rest: list[str]) -> FileCall:
        """FILE base= modulo=."""
        named = name("move_file", rest[0] if rest else "")
        keys = keys_of(rest[1:])
        if unknown := set(keys) - {"base", "modulo"}:
            raise Fault(min(unknown), "move_file accepts only base= and modulo=")
        base = number("base", keys.get("base", str(INTERPOLATION)), -BIG, BIG, "")
        if base != int(base):
            raise Fault("base", f"{base:g}: 1 interpolation cycles, 2 position-controller cycles")
        words = keys["modulo"].split(",") if "modulo" in keys else []
        flags = tuple(None if word == "-" else number("modulo", word, -BIG, BIG, "") for word in words)
        return FileCall(named, int(base), flags, self.offsets.get(named))


def written(call: FileCall, offsets: dict[str, int]) -> list[str]:
    """The statements of a call; offsets: of the files that are open, kept up."""
    lines = []
    if call.offset != offsets.get(call.name):
        if call.offset is None:
            lines.append(f"close {call.name}")
            del offsets[call.name]
        else:
            lines.append(f"read_begin {call.name} {call.offset}")
            offsets[call.name] = call.offset
    flags = ",".join("-" if flag is None else f"{flag:g}" for flag in call.modulo)
    return [*lines, f"move_file {call.name} base={call.base}" + (f" modulo={flags}" if flags else "")]
