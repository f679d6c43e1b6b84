"""The text form of programs: line by line, mm, deg and % outside.  Grammar and examples: docs/guide/motion-programs.md.

read(text) takes a whole text and tells all its faults at once, each with line, key and range; write(program) gives a text that
reads back to the same program (numbers to 1e-12 of their size, orientations to 1e-9 rad).
"""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from typing import TypeVar

from motion.conventions import CONVENTIONS, Convention, convention
from motion.errors import MotionError
from motion.frames import Pose
from motion.kinematics.base import FREE, Configuration, Elbow, Shoulder, Wrist
from motion.program import textkeys
from motion.program.blocks import (
    MAX_JOINTS,
    Blend,
    Block,
    Curving,
    Frame,
    Interpolation,
    JointTarget,
    Output,
    Pace,
    PoseTarget,
    Program,
    Rounding,
    Target,
    Tool,
    Until,
    changed,
)
from motion.program.errors import TextError, TextFaults
from motion.units import from_si, to_si

Part = TypeVar("Part", Pace, Blend, Curving, Block)
Named = TypeVar("Named", Tool, Frame)
MOVES = {kind.value: kind for kind in Interpolation}
FLAGS: dict[str, tuple[str, Enum]] = {
    word.value: (name, word) for name, words in (("shoulder", Shoulder), ("elbow", Elbow), ("wrist", Wrist)) for word in words
}
_EXTRA = re.compile(r"([-+0-9.eE]+)(mm|deg)")
_OUT = re.compile(r"(\d+):([-+0-9.eE]+)(?:@([0-9.eE+]+))?")
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")


class _Fault(Exception):
    """Inside: key, what."""

    def __init__(self, key: str, what: str) -> None:
        self.key, self.what = key, what


@dataclass(slots=True)
class Reader:
    """Line by line: what a stream of statements has said so far."""

    name: str = ""
    robot: str = ""
    angles: Convention = CONVENTIONS["val3"]
    units: tuple[str, ...] = ()
    start: tuple[float, ...] = ()
    tools: dict[str, Tool] = field(default_factory=lambda: {"-": Tool()})
    frames: dict[str, Frame] = field(default_factory=lambda: {"-": Frame()})
    points: dict[str, Target] = field(default_factory=dict)
    modal: dict[str, str] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)

    def statement(self, raw: str, number: int = 0) -> None:
        """One line; raises TextError.  Its block, if it is one, waits for take()."""
        words = raw.partition("#")[0].split()
        if not words:
            return
        try:
            self.line(words, number)
        except _Fault as fault:
            raise TextError(number, fault.key, fault.what) from None
        except TextError:
            raise
        except MotionError as error:
            raise TextError(number, words[0], str(error)) from error

    def take(self) -> list[Block]:
        """Blocks since the last call."""
        blocks, self.blocks = self.blocks, []
        return blocks

    # ---- statements --------------------------------------------------------------------------------------------------
    def line(self, words: list[str], number: int) -> None:
        head, rest = words[0], words[1:]
        match head:
            case "program":
                self.name = _one(head, rest)
            case "robot":
                self.robot = _one(head, rest)
            case "angles":
                if (word := _one(head, rest)) not in CONVENTIONS:
                    raise _Fault(head, f"{word!r}; one of {', '.join(CONVENTIONS)}")
                self.angles = convention(word)
            case "axes":
                if not rest or len(rest) > MAX_JOINTS or any(unit not in ("mm", "deg") for unit in rest):
                    raise _Fault(head, f"1 .. {MAX_JOINTS} units, each mm or deg")
                self.units = tuple(rest)
            case "start":
                self.start = self.joints(head, rest)
            case "tool" | "frame":
                self.place(head, rest)
            case "point":
                self.point(rest)
            case "set":
                self.set(rest)
            case _ if head in MOVES:
                self.move(MOVES[head], rest, number)
            case _:
                raise _Fault("", f"{head!r} is no statement; {', '.join(STATEMENTS)} are")

    def place(self, head: str, rest: list[str]) -> None:
        name = _name(head, rest[0] if rest else "")
        pose = self.pose(head, rest[1:])
        if head == "tool":
            self.tools[name] = Tool(name, pose)
        else:
            self.frames[name] = Frame(name, pose)

    def point(self, rest: list[str]) -> None:
        name = _name("point", rest[0] if rest else "")
        keys = dict(_key(word) for word in rest[1:] if "=" in word)
        if unknown := set(keys) - {"config", "extra"}:
            raise _Fault(min(unknown), "a point takes config= and extra= alone")
        target, left = self.target([word for word in rest[1:] if "=" not in word])
        if left:
            raise _Fault("point", f"{' '.join(left)} is too much")
        self.points[name] = _with(target, keys)

    def set(self, rest: list[str]) -> None:
        keys = dict(_key(word) for word in rest)
        for name in keys:
            if name in ("config", "extra", "out", "until", "time", "weight"):
                raise _Fault(name, "acts on one block alone and is written there")
        self.block(Interpolation.PTP, JointTarget(()), None, {**self.modal, **keys}, 0)  # only to see whether they are legal
        if "radius" in keys:
            self.modal.pop("leave", None), self.modal.pop("reach", None)
        self.modal.update(keys)

    def move(self, kind: Interpolation, rest: list[str], number: int) -> None:
        keys = dict(_key(word) for word in rest if "=" in word)
        words = [word for word in rest if "=" not in word]
        via: PoseTarget | None = None
        if kind is Interpolation.CIRCULAR:
            if not words or words[0] != "via" or "to" not in words:
                raise _Fault("", "circular via TARGET to TARGET")
            split = words.index("to")
            middle, left = self.target(words[1:split])
            if left or not isinstance(middle, PoseTarget):
                raise _Fault("via", "a pose is needed: six numbers after `pose`, or the name of such a point")
            via, words = middle, words[split + 1 :]
        target, left = self.target(words)
        if left:
            raise _Fault("", f"{' '.join(left)} is too much after the target")
        self.blocks.append(self.block(kind, _with(target, keys), via, {**self.modal, **keys}, number))

    # ---- parts -------------------------------------------------------------------------------------------------------
    def target(self, words: list[str]) -> tuple[Target, list[str]]:
        if not words:
            raise _Fault("", "the target is missing: joints .., pose .. or the name of a point")
        match words[0]:
            case "joints":
                return JointTarget(self.joints("joints", words[1:])), []
            case "pose":
                return PoseTarget(self.pose("pose", words[1:])), []
            case name if name in self.points:
                return self.points[name], words[1:]
            case name:
                raise _Fault("", f"point {name!r} is unknown; {', '.join(self.points) or 'none'} are known")

    def pose(self, key: str, words: list[str]) -> Pose:
        if len(words) != 6:
            raise _Fault(key, f"six numbers are needed (x y z mm, three angles deg), {len(words)} are there")
        return self.angles.pose([_number(key, word, -BIG, BIG, "") for word in words])

    def joints(self, key: str, words: list[str]) -> tuple[float, ...]:
        count = len(self.units) or len(self.start) or None
        if not words or (count is not None and len(words) != count):
            raise _Fault(key, f"{len(words)} values; {count or '1 or more'} axes")
        units = self.units or ("deg",) * len(words)
        return tuple(to_si(_number(key, word, -BIG, BIG, unit), unit) for word, unit in zip(words, units, strict=True))

    def block(self, kind: Interpolation, target: Target, via: PoseTarget | None, keys: dict[str, str], number: int) -> Block:
        parts: dict[str, dict[str, object]] = {"pace": {}, "blend": {}, "curving": {}, "": {}}
        if "radius" in keys:
            radius = _number("radius", keys["radius"], 0.0, BIG, "mm") * 1e-3
            parts["blend"] |= {"leave": radius, "reach": radius}
        for name, value in keys.items():
            if name in textkeys.NUMBERS:
                key = textkeys.NUMBERS[name]
                parts[key.part][key.field] = _number(name, value, key.low, key.high, key.unit) * key.si
            elif name in textkeys.WORDS:
                choice = textkeys.WORDS[name]
                parts[choice.part][choice.field] = _word(name, value, choice.words)
            elif name not in textkeys.OTHERS:
                raise _Fault(name, f"no such key; {', '.join(textkeys.NAMES)} are")
        blend = parts["blend"]
        if blend and "rounding" not in blend:
            blend["rounding"] = Rounding.CARTESIAN
        if "zone" in keys:
            blend |= {"axes": self.joints("zone", keys["zone"].split(",")), "rounding": Rounding.JOINT}
        if "arcs" in keys:
            blend["past_circles"] = _yes("arcs", keys["arcs"])
        if "lead" in keys:
            parts["pace"]["lead"] = _yes("lead", keys["lead"])
        made = Block(
            kind,
            target,
            via,
            _filled(Pace(), parts["pace"]),
            _filled(Blend(), blend),
            self.named("tool", keys, self.tools),
            self.named("frame", keys, self.frames),
            curving=_filled(Curving(), parts["curving"]),
            outputs=_outputs(keys.get("out", "")),
            until=_until(keys.get("until", "")),
            line=number,
        )
        return _filled(made, parts[""])

    def named(self, key: str, keys: dict[str, str], known: dict[str, Named]) -> Named:
        name = keys.get(key, "-")
        if name not in known:
            raise _Fault(key, f"{name!r} is unknown; {', '.join(known)} are known")
        return known[name]


BIG = textkeys.BIG
STATEMENTS = ("program", "robot", "angles", "axes", "start", "tool", "frame", "point", "set", *MOVES)


def read(text: str) -> Program:
    """The program of a text; raises TextFaults with every fault in it."""
    reader, faults = Reader(), []
    for number, raw in enumerate(text.splitlines(), 1):
        try:
            reader.statement(raw, number)
        except TextError as fault:
            faults.append(fault)
    if not reader.start:
        faults.append(TextError(0, "start", "is missing: where the axes stand before the first block"))
    if faults:
        raise TextFaults(faults)
    return Program(reader.name, reader.robot, reader.start, tuple(reader.blocks), reader.units)


# ---- words --------------------------------------------------------------------------------------------------------------


def _one(head: str, rest: list[str]) -> str:
    if len(rest) != 1:
        raise _Fault(head, f"one word is needed, {len(rest)} are there")
    return rest[0]


def _name(head: str, word: str) -> str:
    if not NAME.fullmatch(word):
        raise _Fault(head, f"{word!r} is no name: letters, digits, _ . - and a letter first")
    return word


def _key(word: str) -> tuple[str, str]:
    name, sign, value = word.partition("=")
    if not sign or not value:
        raise _Fault(name, f"{word!r}: KEY=VALUE without blanks is needed")
    return name, value


def _number(key: str, word: str, low: float, high: float, unit: str) -> float:
    try:
        value = float(word.removesuffix(unit) if unit and word.endswith(unit) else word)
    except ValueError:
        raise _Fault(key, f"{word!r} is no number") from None
    if not low <= value <= high:  # a NaN fails here too
        suffix = f" {unit}" if unit else ""
        raise _Fault(key, f"{value:g}{suffix} is outside {low:g} .. {high:g}{suffix}")
    return value


def _word(key: str, value: str, words: type[Enum]) -> Enum:
    try:
        return words(value)
    except ValueError:
        raise _Fault(key, f"{value!r}; one of {', '.join(str(word.value) for word in words)}") from None


def _yes(key: str, value: str) -> bool:
    if value not in ("yes", "no"):
        raise _Fault(key, f"{value!r}; yes or no")
    return value == "yes"


def _filled(part: Part, values: dict[str, object]) -> Part:
    for name, value in values.items():
        part = changed(part, name, value)
    return part


def _with(target: Target, keys: dict[str, str]) -> Target:
    """config= and extra= into a pose."""
    if not {"config", "extra"} & set(keys):
        return target
    if not isinstance(target, PoseTarget):
        raise _Fault("config" if "config" in keys else "extra", "needs a pose as target, not joints")
    flags = dict(_flag(word) for word in keys["config"].split(",")) if "config" in keys else {}
    configuration = target.configuration
    for name, flag in flags.items():
        configuration = changed(configuration, name, flag)
    return replace(target, configuration=configuration, extra=_extra(keys["extra"]) if "extra" in keys else target.extra)


def _flag(word: str) -> tuple[str, Enum]:
    if word not in FLAGS:
        raise _Fault("config", f"{word!r}; {', '.join(FLAGS)} are known")
    return FLAGS[word]


def _extra(value: str) -> tuple[float, ...]:
    found = [_EXTRA.fullmatch(word) for word in value.split(",")]
    if not all(found):
        raise _Fault("extra", f"{value!r}: numbers with mm or deg and commas, like 100mm,30deg")
    return tuple(to_si(_number("extra", match[1], -BIG, BIG, ""), match[2]) for match in found if match)


def _outputs(value: str) -> tuple[Output, ...]:
    made = []
    for word in value.split(",") if value else ():
        match = _OUT.fullmatch(word)
        if match is None:
            raise _Fault("out", f"{word!r}: NUMBER:VALUE or NUMBER:VALUE@MM")
        before = _number("out", match[3], 0.0, BIG, "mm") * 1e-3 if match[3] else 0.0
        made.append(Output(int(match[1]), _number("out", match[2], -BIG, BIG, ""), before))
    return tuple(made)


def _until(value: str) -> Until | None:
    if not value:
        return None
    digits = value.removeprefix("!")
    if not digits.isdigit():
        raise _Fault("until", f"{value!r}: the number of an input, with ! in front for its being 0")
    return Until(int(digits), not value.startswith("!"))


# ---- writing ------------------------------------------------------------------------------------------------------------


def write(program: Program, angles: str = "val3") -> str:
    """The text of a program; raises MotionError where one name stands for two tools or frames, or a place has none."""
    ways = convention(angles)
    units = program.units or ("deg",) * len(program.start)
    lines = [f"program {program.name}" if program.name else "", f"robot {program.robot}" if program.robot else ""]
    lines += [f"angles {angles}", f"axes {' '.join(units)}", f"start {_joints(program.start, units)}"]
    for word, places in (
        ("tool", _places(block.tool for block in program.blocks)),
        ("frame", _places(block.frame for block in program.blocks)),
    ):
        lines += [f"{word} {name} {_pose(pose, ways)}" for name, pose in places.items()]
    lines += [_move(block, ways, units) for block in program.blocks]
    return "\n".join(line for line in lines if line) + "\n"


def _places(places: Iterable[Tool | Frame]) -> dict[str, Pose]:
    found: dict[str, Pose] = {}
    for place in places:
        if place.name:
            if found.setdefault(place.name, place.pose) != place.pose:
                raise MotionError(f"{place.name!r} stands for two places in one program")
        elif place.pose != Tool().pose:
            raise MotionError("a tool or frame without a name cannot be written")
    return found


def _move(block: Block, ways: Convention, units: tuple[str, ...]) -> str:
    words = [block.kind.value]
    if block.via is not None:
        words += ["via", f"pose {_pose(block.via.pose, ways)}", "to"]
    target = block.target
    keys = _keys(block, units)
    if isinstance(target, JointTarget):
        words.append(f"joints {_joints(target.q, units)}")
    else:
        words.append(f"pose {_pose(target.pose, ways)}")
        flags = target.configuration
        if flags != FREE:
            keys.append(f"config={','.join(str(getattr(flags, f.name).value) for f in fields(Configuration))}")
        if target.extra:
            own = units[len(units) - len(target.extra) :]
            keys.append(f"extra={','.join(_plain(from_si(value, unit)) + unit for value, unit in zip(target.extra, own, strict=True))}")
    return " ".join([*words, *keys])


def _keys(block: Block, units: tuple[str, ...]) -> list[str]:
    found = []
    plain = Block(block.kind, block.target)
    for key in textkeys.KEYS:
        value = getattr(textkeys.part_of(block, key.part), key.field)
        if value is not None and value != getattr(textkeys.part_of(plain, key.part), key.field):
            found.append(f"{key.name}={_plain(value / key.si)}")
    for choice in textkeys.CHOICES:
        word = getattr(textkeys.part_of(block, choice.part), choice.field)
        if word is not getattr(textkeys.part_of(plain, choice.part), choice.field) or (choice.name == "blend" and block.blend != Blend()):
            found.append(f"{choice.name}={word.value}")
    if block.blend.axes:
        found.append(f"zone={','.join(_plain(from_si(v, unit)) for v, unit in zip(block.blend.axes, units, strict=True))}")
    if block.blend.past_circles:
        found.append("arcs=yes")
    if block.pace.lead:
        found.append("lead=yes")
    found += [f"{word}={place.name}" for word, place in (("tool", block.tool), ("frame", block.frame)) if place.name]
    if block.outputs:
        outs = (f"{o.number}:{_plain(o.value)}{f'@{_plain(o.before * 1e3)}' if o.before else ''}" for o in block.outputs)
        found.append(f"out={','.join(outs)}")
    if block.until is not None:
        found.append(f"until={'' if block.until.value else '!'}{block.until.number}")
    return found


def _joints(values: tuple[float, ...], units: tuple[str, ...]) -> str:
    return " ".join(_plain(from_si(value, unit)) for value, unit in zip(values, units, strict=True))


def _pose(pose: Pose, ways: Convention) -> str:
    return " ".join(_plain(value) for value in ways.values(pose))


def _plain(value: float) -> str:
    """Thirteen digits, without the dust of unit conversion."""
    rounded = float(f"{value:.13g}")
    if rounded == 0.0 or math.isclose(rounded, 0.0, abs_tol=1e-13):
        return "0"
    return str(int(rounded)) if rounded.is_integer() and abs(rounded) < 1e12 else repr(rounded)
