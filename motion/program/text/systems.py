"""Workpiece systems in the text form: `wc_frame NAME dx dy dz da db dc` (mm, deg as the rho 3 has them), `wc_system NAME`."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.program.text.words import Fault, name, number, one
from motion.rho3.wc import LONGEST_NAME, WC_UR, WcFrame

HEADS = ("wc_frame", "wc_system")
ORIGINAL = "WC_UR"
BIG = 1e6


@dataclass(slots=True)
class Systems:
    """What a text has declared so far; active: the one its blocks are in, None: the one in force when it begins."""

    known: dict[str, WcFrame] = field(default_factory=lambda: {ORIGINAL: WC_UR})
    active: WcFrame | None = None

    def line(self, head: str, rest: list[str]) -> None:
        """One of HEADS."""
        if head == "wc_frame":
            self._declared(rest)
            return
        named = one(head, rest)
        if named not in self.known:
            raise Fault(head, f"{named!r} is unknown; {', '.join(self.known)} are known")
        self.active = self.known[named]

    def _declared(self, rest: list[str]) -> None:
        named = name("wc_frame", rest[0] if rest else "")
        if len(named) > LONGEST_NAME:
            raise Fault("wc_frame", f"{named}: a name has at most {LONGEST_NAME} characters")
        if named in self.known:
            raise Fault("wc_frame", f"{named} exists already")
        if len(rest) != 7:
            raise Fault("wc_frame", f"six numbers are needed (dx dy dz mm, da db dc deg), found {len(rest) - 1}")
        dx, dy, dz, da, db, dc = (number("wc_frame", word, -BIG, BIG, "") for word in rest[1:])
        self.known[named] = WcFrame(dx, dy, dz, da, db, dc, name=named)


def declared(systems: Iterable[WcFrame | None]) -> list[str]:
    """Lines of the frames blocks are in; MotionError where one name is used for two, or a frame has none."""
    found: dict[str, WcFrame] = {}
    for system in systems:
        if system is None or system == WC_UR:
            continue
        if not system.name:
            raise MotionError("a workpiece system without a name cannot be written")
        if found.setdefault(system.name, system) != system:
            raise MotionError(f"{system.name!r} names two workpiece systems in one program")
    return [f"wc_frame {each.name} {' '.join(f'{value:.13g}' for value in each.values)}" for each in found.values()]


def chosen(system: WcFrame | None) -> str:
    """The statement that makes blocks be in it."""
    return f"wc_system {ORIGINAL if system is None or system == WC_UR else system.name}"
