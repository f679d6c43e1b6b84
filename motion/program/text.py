"""The text form of programs: line by line, mm, deg and % outside.  Grammar and examples: docs/guide/motion-programs.md.

read(text) takes a whole text and tells all its faults at once, each with line, key and range; motion.program.textout writes one.
"""

import re
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TypeVar

from motion.conventions import CONVENTIONS, Convention, convention
from motion.errors import MotionError
from motion.frames import Pose
from motion.kinematics.base import Elbow, Shoulder, Wrist
from motion.outputs.function import Function
from motion.program import textkeys
from motion.program.blocks import (
    MAX_JOINTS,
    MEASURED,
    Blend,
    Block,
    Curving,
    Frame,
    Interpolation,
    JointTarget,
    OnBelt,
    Output,
    Pace,
    PoseTarget,
    Program,
    Rounding,
    Synchron,
    Target,
    Tool,
    Until,
    changed,
)
from motion.program.errors import TextError, TextFaults
from motion.program.textalter import AlterParts
from motion.program.textwords import Fault as _Fault
from motion.program.textwords import key as _key
from motion.program.textwords import name as _name
from motion.program.textwords import number as _number
from motion.program.textwords import one as _one
from motion.program.textwords import word as _word
from motion.program.textwords import yes as _yes
from motion.units import to_si

Part = TypeVar("Part", Pace, Blend, Curving, Block)
Named = TypeVar("Named", Tool, Frame)
MOVES = {kind.value: kind for kind in Interpolation}
FLAGS: dict[str, tuple[str, Enum]] = {
    word.value: (name, word) for name, words in (("shoulder", Shoulder), ("elbow", Elbow), ("wrist", Wrist)) for word in words
}
_EXTRA = re.compile(r"([-+0-9.eE]+)(mm|deg)")
_UNTIL = re.compile(r"(!?)(ch)?(\d+)")
_OUT = re.compile(r"(\d+):([-+0-9.eE]+)(?:@([0-9.eE+]+))?")


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
    part: Synchron | None = None  # SYNCHRON without SYNCHRON_END so far
    parts: int = 0
    altered: AlterParts = field(default_factory=AlterParts)
    labels: dict[str, int] = field(default_factory=dict)  # blocks before it
    label: str = ""  # in front of the next block
    errors: list[tuple[int, str, int]] = field(default_factory=list)  # line, label, number of the block that names it
    count: int = 0  # blocks so far
    functions: tuple[Function, ...] = ()  # in front of the next block

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

    def ended(self) -> None:
        """The text is over: labels that blocks name stand behind them; raises TextError."""
        for line, name, block in self.errors:
            if self.labels.get(name, -1) < block:
                raise TextError(line, "error", f"label {name} does not stand behind the block")
        if self.functions:
            raise TextError(0, "ppo" if self.functions[0].ppo else "iol", "begins with a block, and none follows")

    # ---- statements --------------------------------------------------------------------------------------------------
    def line(self, words: list[str], number: int) -> None:
        head, rest = words[0], words[1:]
        match head:
            case "program" | "robot" | "angles" | "axes" | "start":
                self.heading(head, rest)
            case "tool" | "frame":
                self.place(head, rest)
            case "point":
                self.point(rest)
            case "set":
                self.set(rest)
            case "synchron" | "synchron_end":
                self.synchron(head, rest)
            case "iol" | "ppo":
                self.functions = (*self.functions, _function(head, rest))
            case "alter":
                self.altered.begin(rest, self.tools, self.frames)
            case "alter_end":
                self.altered.end(rest)
            case "label":
                self.named_place(head, rest)
            case _ if head in MOVES:
                self.move(MOVES[head], rest, number)
            case _:
                raise _Fault("", f"{head!r} is no statement; {', '.join(STATEMENTS)} are")

    def heading(self, head: str, rest: list[str]) -> None:
        """What is said of the program as a whole."""
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
            case _:
                self.start = self.joints(head, rest)

    def named_place(self, head: str, rest: list[str]) -> None:
        self.label = _name(head, _one(head, rest))
        if self.label in self.labels:
            raise _Fault(head, f"{self.label} stands twice")
        self.labels[self.label] = self.count

    def synchron(self, head: str, rest: list[str]) -> None:
        if head == "synchron_end":
            if self.part is None or rest not in ([], [self.part.belt]):
                raise _Fault(head, "ends no synchronous part; `synchron BELT` begins one")
            self.part = None
            return
        if self.part is not None:
            raise _Fault("synchron", f"the part on belt {self.part.belt} is not ended: synchron_end")
        name = _name("synchron", rest[0] if rest else "")
        keys = dict(_key(word) for word in rest[1:])
        if unknown := set(keys) - {"at"}:
            raise _Fault(min(unknown), "synchron takes at= alone")
        self.parts += 1
        self.part = Synchron(name, _length("at", keys["at"]) if "at" in keys else None, self.parts)

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
            if name in ONCE:
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
        block = self.block(kind, _with(target, keys), via, {**self.modal, **keys}, number)
        self.blocks.append(block)
        self.label, self.functions, self.count = "", (), self.count + 1
        if block.until is not None and block.until.error:
            self.errors.append((number, block.until.error, self.count))

    # ---- parts -------------------------------------------------------------------------------------------------------
    def target(self, words: list[str]) -> tuple[Target, list[str]]:
        if not words:
            raise _Fault("", "the target is missing: joints .., pose .. or the name of a point")
        match words[0]:
            case "joints":
                return JointTarget(self.joints("joints", words[1:])), []
            case "pose":
                return PoseTarget(self.pose("pose", words[1:])), []
            case "mpos":
                return MEASURED, words[1:]
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
            functions=self.functions,
            until=_until(keys),
            synchron=self.part,
            on_belt=self.on_belt(keys),
            alteration=self.altered.part,
            freeze=self.altered.freeze(keys.get("freeze")),
            label=self.label,
            line=number,
        )
        return _filled(made, parts[""])

    def on_belt(self, keys: dict[str, str]) -> OnBelt | None:
        given = [name for name in ("belt", "camin", "camout") if name in keys]
        if given and self.part is None:
            raise _Fault(given[0], "stands in a synchronous part alone: synchron BELT before it")
        if given and "belt" not in keys:
            raise _Fault(given[0], "needs the block's value of the belt: belt=")
        return OnBelt(*(_length(name, keys[name]) if name in keys else 0.0 for name in ("belt", "camin", "camout"))) if given else None

    def named(self, key: str, keys: dict[str, str], known: dict[str, Named]) -> Named:
        name = keys.get(key, "-")
        if name not in known:
            raise _Fault(key, f"{name!r} is unknown; {', '.join(known)} are known")
        return known[name]


BIG = textkeys.BIG
HEADINGS = ("program", "robot", "angles", "axes", "start")
OTHERS = ("tool", "frame", "point", "set", "synchron", "synchron_end", "alter", "alter_end", "label", "iol", "ppo")
STATEMENTS = (*HEADINGS, *OTHERS, *MOVES)
ONCE = ("config", "extra", "out", "until", "error", "time", "weight", "belt", "camin", "camout", "freeze")  # of one block alone


def read(text: str) -> Program:
    """The program of a text; raises TextFaults with every fault in it."""
    reader, faults = Reader(), []
    for number, raw in enumerate(text.splitlines(), 1):
        try:
            reader.statement(raw, number)
        except TextError as fault:
            faults.append(fault)
    try:
        reader.ended()
    except TextError as fault:
        faults.append(fault)
    if not reader.start:
        faults.append(TextError(0, "start", "is missing: where the axes stand before the first block"))
    if faults:
        raise TextFaults(faults)
    return Program(reader.name, reader.robot, reader.start, tuple(reader.blocks), reader.units)


# ---- words --------------------------------------------------------------------------------------------------------------


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


def _length(key: str, value: str) -> float:
    found = _EXTRA.fullmatch(value)
    if found is None:
        raise _Fault(key, f"{value!r}: a number with mm or deg, like 150mm")
    return to_si(_number(key, found[1], -BIG, BIG, ""), found[2])


def _outputs(value: str) -> tuple[Output, ...]:
    made = []
    for word in value.split(",") if value else ():
        match = _OUT.fullmatch(word)
        if match is None:
            raise _Fault("out", f"{word!r}: NUMBER:VALUE or NUMBER:VALUE@MM")
        before = _number("out", match[3], 0.0, BIG, "mm") * 1e-3 if match[3] else 0.0
        made.append(Output(int(match[1]), _number("out", match[2], -BIG, BIG, ""), before))
    return tuple(made)


def _function(head: str, rest: list[str]) -> Function:
    """In the order of the manual: no, KIN_NO, COORD_NO, IO_POSITION, PARAM_VALUE, TIME_OFFS."""
    if len(rest) != 6:
        raise _Fault(head, "six numbers: function, kinematic, coordinate, position (mm or deg), value, time offset (ms)")
    numbers = [_number(head, word, -BIG, BIG, "") for word in rest]
    whole = [int(numbers[n]) for n in (0, 1, 2, 5)]
    if any(numbers[n] != value for n, value in zip((0, 1, 2, 5), whole, strict=True)):
        raise _Fault(head, "function, kinematic, coordinate and time offset are whole numbers")
    return Function(head == "ppo", whole[0], whole[1], whole[2], numbers[3], numbers[4], whole[3])


def _until(keys: dict[str, str]) -> Until | None:
    if "until" not in keys:
        if "error" in keys:
            raise _Fault("error", "belongs to until=, whose input never came")
        return None
    match = _UNTIL.fullmatch(keys["until"])
    if match is None:
        raise _Fault("until", f"{keys['until']!r}: the number of an input (464) or a channel (ch610), with ! in front for its being 0")
    number, error = int(match[3]), _name("error", keys["error"]) if "error" in keys else ""
    return Until(0 if match[2] else number, not match[1], number if match[2] else 0, error)
