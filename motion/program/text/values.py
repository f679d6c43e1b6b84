"""Values of the text form: what a word or KEY=VALUE means for a block, without knowing its line.  Each raises Fault."""

import re
from dataclasses import replace
from enum import Enum
from typing import TypeVar

from motion.geometry.frames import Vector
from motion.geometry.units import to_si
from motion.kinematics.base import Elbow, Shoulder, Wrist
from motion.outputs.function import Function
from motion.program.blocks import BeltCall, Blend, Block, Curving, Output, Pace, PoseTarget, Shift, Sync, Target, Until, changed
from motion.program.text import keys as textkeys
from motion.program.text.words import Fault, name, number
from motion.rho3.kinematic import PLANES, mirrored

Part = TypeVar("Part", Pace, Blend, Curving, Block)
BIG = textkeys.BIG
LONGEST_WITHIN_S = 1e6
MOST = 11  # blocks prepared while one runs (rho 3 L7953)
FLAGS: dict[str, tuple[str, Enum]] = {
    word.value: (field, word) for field, words in (("shoulder", Shoulder), ("elbow", Elbow), ("wrist", Wrist)) for word in words
}
_EXTRA = re.compile(r"([-+0-9.eE]+)(mm|deg)")
_UNTIL = re.compile(r"(!?)(ch)?(\d+)")
_INPUT = re.compile(r"(!?)(\d+)")
_OUT = re.compile(r"(\d+):([-+0-9.eE]+)(?:@([0-9.eE+]+))?")
CALLS = {"belt_param": (15, 4), "belt_type": (21, 2), "set_beltcnt": (28, 2)}  # special function, count of following numbers
CALLED = {function: head for head, (function, _) in CALLS.items()}


def filled(part: Part, values: dict[str, object]) -> Part:
    """A copy with these fields."""
    return changed(part, values) if values else part


def corner_of(key: str, word: str) -> Vector | None:
    """x,y,z in mm, or - for none."""
    if word == "-":
        return None
    parts = word.split(",")
    if len(parts) != 3:
        raise Fault(key, f"three values x,y,z or -, not {word!r}")
    x, y, z = (number(key, part, -BIG, BIG, "mm") * 1e-3 for part in parts)
    return (x, y, z)


def shift_of(words: list[str]) -> tuple[float, ...]:
    """Differences of a pose: three of mm, three of deg; m and rad."""
    if len(words) != 6:
        raise Fault("rel pose", f"six numbers are needed (x y z mm, three angles deg), found {len(words)}")
    units = ("mm",) * 3 + ("deg",) * 3
    return tuple(to_si(number("rel pose", word, -BIG, BIG, ""), unit) for word, unit in zip(words, units, strict=True))


def mirrored_target(target: Target | Shift, plane: str, *, asked: bool) -> Target | Shift:
    """SF 17 MIRROR; asked: for this block alone, which then has to name a pose.  Places of axes stay as they are (L8962-8976)."""
    if plane == "-":
        return target
    if plane not in PLANES:
        raise Fault("mirror", f"{plane!r}: {', '.join(PLANES)}, or - for none")
    across = PLANES[plane]
    if isinstance(target, PoseTarget):
        return replace(target, pose=mirrored(target.pose, across))
    if isinstance(target, Shift) and target.angles is not None:  # three lengths, three turns about x, y and z
        signs = [-1.0 if n == across else 1.0 if n < 3 or n == across + 3 else -1.0 for n in range(6)]
        return replace(target, values=tuple(value * sign for value, sign in zip(target.values, signs, strict=True)))
    if asked:
        raise Fault("mirror", "needs a pose as target, not places of axes")
    return target


def placed(target: Target | Shift, keys: dict[str, str]) -> Target | Shift:
    """config= and extra= into a pose."""
    if not {"config", "extra"} & set(keys):
        return target
    if isinstance(target, Shift) and target.angles is not None:
        if "config" in keys:
            raise Fault("config", "a relative target keeps the configuration")
        return replace(target, extra=_extra(keys["extra"]))
    if not isinstance(target, PoseTarget):
        raise Fault("config" if "config" in keys else "extra", "needs a pose as target, not joints")
    flags = dict(_flag(word) for word in keys["config"].split(",")) if "config" in keys else {}
    configuration = target.configuration
    for field, flag in flags.items():
        configuration = changed(configuration, {field: flag})
    return replace(target, configuration=configuration, extra=_extra(keys["extra"]) if "extra" in keys else target.extra)


def _flag(word: str) -> tuple[str, Enum]:
    if word not in FLAGS:
        raise Fault("config", f"{word!r}; {', '.join(FLAGS)} are known")
    return FLAGS[word]


def _extra(value: str) -> tuple[float, ...]:
    found = [_EXTRA.fullmatch(word) for word in value.split(",")]
    if not all(found):
        raise Fault("extra", f"{value!r}: numbers with mm or deg and commas, like 100mm,30deg")
    return tuple(to_si(number("extra", match[1], -BIG, BIG, ""), match[2]) for match in found if match)


def length_of(key: str, value: str) -> float:
    """150mm, 30deg; m or rad."""
    found = _EXTRA.fullmatch(value)
    if found is None:
        raise Fault(key, f"{value!r}: a number with mm or deg, like 150mm")
    return to_si(number(key, found[1], -BIG, BIG, ""), found[2])


def outputs_of(value: str) -> tuple[Output, ...]:
    """NUMBER:VALUE@MM, with commas."""
    made = []
    for word in value.split(",") if value else ():
        match = _OUT.fullmatch(word)
        if match is None:
            raise Fault("out", f"{word!r}: NUMBER:VALUE or NUMBER:VALUE@MM")
        before = number("out", match[3], 0.0, BIG, "mm") * 1e-3 if match[3] else 0.0
        made.append(Output(int(match[1]), number("out", match[2], -BIG, BIG, ""), before))
    return tuple(made)


def function_of(head: str, rest: list[str]) -> Function:
    """In the order of the manual: no, KIN_NO, COORD_NO, IO_POSITION, PARAM_VALUE, TIME_OFFS."""
    if len(rest) != 6:
        raise Fault(head, "six numbers: function, kinematic, coordinate, position (mm or deg), value, time offset (ms)")
    numbers = [number(head, word, -BIG, BIG, "") for word in rest]
    whole = [int(numbers[n]) for n in (0, 1, 2, 5)]
    if any(numbers[n] != value for n, value in zip((0, 1, 2, 5), whole, strict=True)):
        raise Fault(head, "function, kinematic, coordinate and time offset are whole numbers")
    return Function(head == "ppo", whole[0], whole[1], whole[2], numbers[3], numbers[4], whole[3])


def search_of(head: str, rest: list[str]) -> int:
    """BLOCK_SEARCH: number of blocks; - for all known ones."""
    word = rest[0] if len(rest) == 1 else ""
    if word == "-":
        return 0
    if not word.isdecimal() or not 1 <= int(word) <= MOST:
        raise Fault(head, f"{' '.join(rest)!r}: 1 .. {MOST} blocks that are prepared while one is run, or - for all that are known")
    return int(word)


def until_of(keys: dict[str, str]) -> Until | None:
    """until=, within= and error= of a block."""
    if "until" not in keys:
        if "within" in keys:
            raise Fault("within", "belongs to until=: it limits the time that the block moves")
        if "error" in keys:
            raise Fault("error", "belongs to until=, whose input never occurred")
        return None
    match = _UNTIL.fullmatch(keys["until"])
    if match is None:
        raise Fault("until", f"{keys['until']!r}: the number of an input (464) or a channel (ch610), with ! in front for its being 0")
    wanted, error = int(match[3]), name("error", keys["error"]) if "error" in keys else ""
    within = number("within", keys["within"], 0.0, LONGEST_WITHIN_S, "s") if "within" in keys else None
    return Until(0 if match[2] else wanted, not match[1], wanted if match[2] else 0, error, within)


def sync_of(head: str, rest: list[str], *, inside: bool) -> Sync:
    """`BELT >= 100mm`, `BELT <= 100mm`, `BELT input=464`, `BELT input=!464`."""
    belt = name(head, rest[0] if rest else "")
    match rest[1:]:
        case ["<=" | ">=" as sign, value]:
            return Sync(belt, length_of(head, value), sign == ">=", inside=inside)
        case [word] if word.startswith("input="):
            found = _INPUT.fullmatch(word.removeprefix("input="))
            if found is not None:
                return Sync(belt, input=int(found[2]), level=not found[1], inside=inside)
    raise Fault(head, "BELT >= 100mm, BELT <= 100mm or BELT input=464 (input=!464)")


def call_of(head: str, rest: list[str], *, inside: bool) -> BeltCall:
    """Numbers in the order and units of the manual: belt from 1, then mm or deg, per s, ms."""
    function, count = CALLS[head]
    if len(rest) != count:
        raise Fault(head, f"{count} numbers, found {len(rest)}")
    belt, *values = (number(head, word, -BIG, BIG, "") for word in rest)
    if belt != int(belt) or (function != 28 and values[-1] != int(values[-1])):
        raise Fault(head, "numbers of belts, types and times in ms are whole numbers")
    return BeltCall(function, int(belt), tuple(values), inside=inside)
