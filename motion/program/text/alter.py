"""`alter` .. `alter_end` of the text form: blocks a correction from outside may move while they run (VAL 3 13.1; AX-547)."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from motion.program.blocks import Alteration, Frame, Tool, Until
from motion.program.text.words import Fault, keys, number, yes
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import Mdesc

_INPUT = re.compile(r"(!?)(\d+)")
NUMBERS = {  # unit, default: vel, tvel, rvel, accel, decel of an mdesc (L5712)
    "speed": ("%", "100"),
    "path": ("mm/s", "9999"),
    "turn": ("deg/s", "9999"),
    "accel": ("%", "100"),
    "decel": ("%", "100"),
}
BIG = 1e6


@dataclass(slots=True)
class AlterParts:
    """Statements about alterable parts in a text so far."""

    part: Alteration | None = None
    count: int = 0

    def begin(self, rest: list[str], tools: Mapping[str, Tool], frames: Mapping[str, Frame]) -> None:
        """`alter frame NAME` or `alter tool NAME`, and keys."""
        if self.part is not None:
            raise Fault("alter", "the alterable part before is not ended: alter_end (VAL 3 alterBegin -1)")
        if len(rest) < 2 or rest[0] not in ("frame", "tool"):
            raise Fault(
                "alter", "`alter frame NAME` or `alter tool NAME`: whose coordinates the correction has; - for the robot's base or flange"
            )
        known: Mapping[str, Tool | Frame] = tools if rest[0] == "tool" else frames
        if rest[1] not in known:
            raise Fault("alter", f"{rest[0]} {rest[1]!r} is unknown; {', '.join(known)} are known")
        self.count += 1
        self.part = _limited(known[rest[1]], keys(rest[2:]), self.count)

    def end(self, rest: list[str]) -> None:
        """`alter_end`."""
        if self.part is None or rest:
            raise Fault("alter_end", "ends no alterable part; `alter frame NAME` begins one (VAL 3 alterEnd -1)")
        self.part = None

    def freeze(self, given: str | None) -> bool:
        """freeze= of a block."""
        if given is not None and self.part is None:
            raise Fault("freeze", "is allowed in an alter section only: write `alter frame NAME` before it")
        return given is not None and yes("freeze", given)


def _limited(reference: Tool | Frame, keys: dict[str, str], count: int) -> Alteration:
    if unknown := set(keys) - {*NUMBERS, "until"}:
        raise Fault(min(unknown), f"alter accepts only {', '.join(NUMBERS)} and until")
    speed, path, turn, accel, decel = (number(name, keys.get(name, default), -BIG, BIG, unit) for name, (unit, default) in NUMBERS.items())
    limits = Mdesc(accel, speed, decel, path, turn)
    try:
        limits.check()
    except RuntimeFault as fault:
        raise Fault("alter", str(fault)) from fault
    return Alteration(reference, speed / 100.0, path * 1e-3, math.radians(turn), accel / 100.0, decel / 100.0, _until(keys), count)


def _until(keys: dict[str, str]) -> Until | None:
    if "until" not in keys:
        return None
    found = _INPUT.fullmatch(keys["until"])
    if found is None:
        raise Fault("until", f"{keys['until']!r}: the number of an input (464), with ! in front for its being 0")
    return Until(int(found[2]), not found[1])


def written(part: Alteration) -> str:
    """The statement that begins it."""
    values = (part.speed * 100.0, part.path * 1e3, math.degrees(part.turn), part.accel * 100.0, part.decel * 100.0)
    words = [f"{name}={value:.13g}" for name, value in zip(NUMBERS, values, strict=True)]
    if part.until is not None:
        words.append(f"until={'' if part.until.value else '!'}{part.until.number}")
    kind = "tool" if isinstance(part.reference, Tool) else "frame"
    return " ".join(["alter", kind, part.reference.name or "-", *words])
