"""The text form of programs: line by line, mm, deg and % outside.  Grammar and examples: docs/guide/motion-programs.md.

read(text) reads a complete text and reports all its faults at once, each with line, key and range; motion.program.text.writer writes one.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

from motion.geometry.conventions import CONVENTIONS, Convention, convention
from motion.geometry.frames import Pose
from motion.geometry.units import to_si
from motion.program.blocks import (
    MAX_JOINTS,
    MEASURED,
    UNKNOWN,
    Act,
    Blend,
    Block,
    Called,
    Curving,
    Frame,
    Interpolation,
    JointTarget,
    MachinePoint,
    OnBelt,
    Pace,
    PoseTarget,
    Program,
    Rounding,
    Shift,
    Synchron,
    Target,
    Tool,
)
from motion.program.errors import TextError, TextFaults
from motion.program.text import keys as textkeys
from motion.program.text.alter import AlterParts
from motion.program.text.files import HEADS as FILE_HEADS
from motion.program.text.files import OpenFiles
from motion.program.text.inputs import FUNCTIONS as MEASURING
from motion.program.text.inputs import called, entry_of, wait_of
from motion.program.text.labels import Labels
from motion.program.text.systems import HEADS as SYSTEM_HEADS
from motion.program.text.systems import Systems
from motion.program.text.values import (
    CALLS,
    call_of,
    corner_of,
    filled,
    function_of,
    length_of,
    mirrored_target,
    outputs_of,
    placed,
    search_of,
    shift_of,
    sync_of,
    until_of,
)
from motion.program.text.words import Fault as _Fault
from motion.program.text.words import keys as _keys
from motion.program.text.words import name as _name
from motion.program.text.words import number as _number
from motion.program.text.words import one as _one
from motion.program.text.words import statement
from motion.program.text.words import word as _word
from motion.program.text.words import yes as _yes

Named = TypeVar("Named", Tool, Frame)
MOVES = {kind.value: kind for kind in Interpolation}


@dataclass(slots=True)
class Reader:
    """Reads line by line: the state of a stream of statements so far."""

    name: str = ""
    robot: str = ""
    angles: Convention = CONVENTIONS["val3"]
    units: tuple[str, ...] = ()
    start: tuple[float, ...] = ()
    tools: dict[str, Tool] = field(default_factory=lambda: {"-": Tool()})
    frames: dict[str, Frame] = field(default_factory=lambda: {"-": Frame()})
    points: dict[str, Target | Shift] = field(default_factory=dict)
    modal: dict[str, str] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    part: Synchron | None = None  # SYNCHRON without SYNCHRON_END so far
    parts: int = 0
    altered: AlterParts = field(default_factory=AlterParts)
    files: OpenFiles = field(default_factory=OpenFiles)
    systems: Systems = field(default_factory=Systems)
    labels: Labels = field(default_factory=Labels)
    ahead: int = 0
    functions: tuple[Called, ...] = ()  # before the next block
    acts: tuple[Act, ...] = ()  # before the next block, or after the last one

    @property
    def inside(self) -> bool:
        """Of a synchronous or alterable part."""
        return self.part is not None or self.altered.part is not None

    @property
    def untold(self) -> bool:
        """Nothing but the name of the program was read."""
        return self == Reader(self.name)

    def statement(self, raw: str, number: int = 0) -> None:
        """Read one line; its block, if any, waits for take().  Raise TextError."""
        statement(raw, number, self.line)

    def take(self) -> list[Block]:
        """Blocks since the last call."""
        blocks, self.blocks = self.blocks, []
        return blocks

    def ended(self) -> None:
        """End the text: labels named by blocks must follow them, and statements that begin with a block must have one.  Raise TextError."""
        self.labels.ended()
        self.check_begun()

    def check_begun(self) -> None:
        """What begins with a block has one, each part is followed by its end; raises TextError."""
        if self.functions:
            raise TextError(0, called(self.functions[0]).split()[0], "begins with a block, and none follows")
        if self.part is not None and self.acts and self.acts[-1].inside:
            raise TextError(0, "synchron_end", f"is missing: sync is the last statement of the part on belt {self.part.belt}")

    # ---- statements --------------------------------------------------------------------------------------------------
    def line(self, words: list[str], number: int) -> None:
        head, rest = words[0], words[1:]
        match head:
            case "program" | "robot" | "angles" | "axes" | "start" | "kinematic":
                self.heading(head, rest)
            case "tool" | "frame":
                self.place(head, rest)
            case "point":
                self.point(rest)
            case "set":
                self.set(rest)
            case "synchron" | "synchron_end":
                self.synchron(head, rest, number)
            case _ if head in FUNCTIONS:
                self.functions = (*self.functions, FUNCTIONS[head](head, rest))
            case "alter":
                self.altered.begin(rest, self.tools, self.frames)
            case "alter_end":
                self.altered.end(rest)
            case _ if head in FILE_HEADS:
                self.file(head, rest, number)
            case _ if head in SYSTEM_HEADS:
                self.systems.line(head, rest)
            case _ if head in ACTS:
                self.acts = (*self.acts, self.act(head, rest))
            case "label" | "block_search":
                self.before_blocks(head, rest)
            case _ if head in MOVES:
                self.move(MOVES[head], rest, number)
            case _:
                raise _Fault("", f"{head!r} is not a statement; {', '.join(STATEMENTS)} are")

    def act(self, head: str, rest: list[str]) -> Act:
        if head == "mach_pos":
            if rest[:1] != ["joints"]:
                raise _Fault(head, "mach_pos joints, and the place of each axis")
            return MachinePoint(self.joints(head, rest[1:]), inside=self.inside)
        return (sync_of if head == "sync" else call_of)(head, rest, inside=self.inside)

    def heading(self, head: str, rest: list[str]) -> None:
        """Read a statement about the entire program."""
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
            case "kinematic":
                raise _Fault(head, "must come first in a program of several kinematics")
            case _:
                self.start = self.joints(head, rest)

    def before_blocks(self, head: str, rest: list[str]) -> None:
        if head == "block_search":
            self.ahead = search_of(head, rest)
        else:
            self.labels.line(head, rest, acting=bool(self.acts))

    def synchron(self, head: str, rest: list[str], number: int) -> None:
        if head == "synchron_end":
            if self.part is None or rest not in ([], [self.part.belt]):
                raise _Fault(head, "ends no synchronous part; `synchron BELT` begins one")
            if self.acts and self.acts[-1].inside:
                self.move(Interpolation.LINEAR, NO_WAY, number)  # they belong to a block of their part
            self.part = None
            return
        if self.part is not None:
            raise _Fault("synchron", f"the part on belt {self.part.belt} is not ended: synchron_end")
        name = _name("synchron", rest[0] if rest else "")
        keys = _keys(rest[1:])
        if unknown := set(keys) - {"at"}:
            raise _Fault(min(unknown), "synchron accepts only at=")
        self.parts += 1
        self.part = Synchron(name, length_of("at", keys["at"]) if "at" in keys else None, self.parts)

    def place(self, head: str, rest: list[str]) -> None:
        name = _name(head, rest[0] if rest else "")
        pose = self.pose(head, rest[1:])
        if head == "tool":
            self.tools[name] = Tool(name, pose)
        else:
            self.frames[name] = Frame(name, pose)

    def point(self, rest: list[str]) -> None:
        name = _name("point", rest[0] if rest else "")
        keys = _keys(word for word in rest[1:] if "=" in word)
        if unknown := set(keys) - {"config", "extra"}:
            raise _Fault(min(unknown), "a point accepts only config= and extra=")
        target, left = self.target([word for word in rest[1:] if "=" not in word])
        if left:
            raise _Fault("point", f"{' '.join(left)} is too much")
        self.points[name] = placed(target, keys)

    def set(self, rest: list[str]) -> None:
        keys = _keys(rest)
        for name in keys:
            if name in ONCE:
                raise _Fault(name, "acts on one block only and is written there")
        self.block(Interpolation.PTP, JointTarget(()), None, {**self.modal, **keys}, 0)  # only to see whether they are legal
        mirrored_target(JointTarget(()), keys.get("mirror", "-"), asked=False)
        if "radius" in keys:
            self.modal.pop("leave", None), self.modal.pop("reach", None)
        self.modal.update(keys)

    def move(self, kind: Interpolation, rest: list[str], number: int) -> None:
        keys = _keys(word for word in rest if "=" in word)
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
        index = 0
        if words[:1] == ["recorded"]:
            index, words = entry_of(words[1:]), ["mpos"]
        target, left = self.target(words)
        if left:
            raise _Fault("", f"{' '.join(left)} is too much after the target")
        otherwise = keys.pop("error", "") if target == MEASURED and "until" not in keys else ""
        plane = keys.get("mirror", self.modal.get("mirror", "-"))
        target = mirrored_target(placed(target, keys), plane, asked=keys.get("mirror", "-") != "-")
        if via is not None and isinstance(other := mirrored_target(via, plane, asked=False), PoseTarget):
            via = other
        block = self.block(kind, target, via, {**self.modal, **keys}, number)
        if block.shift is not None and kind not in RELATIVE:
            raise _Fault("rel", f"a relative target is one of {' and '.join(word.value for word in RELATIVE)}, not of {kind.value}")
        if index and (kind not in RELATIVE or self.inside):
            raise _Fault("recorded", "is a target of ptp and linear, outside of synchronous and alterable parts")
        if otherwise:
            block = replace(block, otherwise=_name("error", otherwise))
        self.added(replace(block, recorded=index, target=UNKNOWN) if index else block)

    def file(self, head: str, rest: list[str], number: int) -> None:
        """MOVE_FILE, and what opens and closes its file."""
        match head:
            case "read_begin":
                self.files.read_begin(rest)
            case "close":
                self.files.close(rest)
            case _:
                if self.inside:
                    raise _Fault(head, "is not allowed in synchronous and alter sections")
                block = self.block(Interpolation.PTP, UNKNOWN, None, {}, number)
                self.added(replace(block, file=self.files.call(rest)))

    def added(self, block: Block) -> None:
        """One more; what preceded it belongs to it."""
        self.blocks.append(block)
        self.labels.asked(block.line, block.goes_on_at)
        self.labels.added()
        self.functions, self.acts = (), ()

    # ---- parts -------------------------------------------------------------------------------------------------------
    def target(self, words: list[str]) -> tuple[Target | Shift, list[str]]:
        if not words:
            raise _Fault("", "the target is missing: joints .., pose .., rel joints .., rel pose .. or the name of a point")
        match words[0]:
            case "joints":
                return JointTarget(self.joints("joints", words[1:])), []
            case "pose":
                return PoseTarget(self.pose("pose", words[1:])), []
            case "mpos":
                return MEASURED, words[1:]
            case "rel":
                return self.shift(words[1:]), []
            case name if name in self.points:
                return self.points[name], words[1:]
            case name:
                raise _Fault("", f"point {name!r} is unknown; {', '.join(self.points) or 'none'} are known")

    def shift(self, words: list[str]) -> Shift:
        match words[:1]:
            case ["joints"]:
                return Shift(self.joints("rel joints", words[1:]))
            case ["pose"]:
                return Shift(shift_of(words[1:]), self.angles)
        raise _Fault("rel", "rel joints .. (one difference for each axis) or rel pose .. (x y z mm, three angles deg)")

    def pose(self, key: str, words: list[str]) -> Pose:
        if len(words) != 6:
            raise _Fault(key, f"six numbers are needed (x y z mm, three angles deg), found {len(words)}")
        return self.angles.pose([_number(key, word, -BIG, BIG, "") for word in words])

    def joints(self, key: str, words: list[str]) -> tuple[float, ...]:
        count = len(self.units) or len(self.start) or None
        if not words or (count is not None and len(words) != count):
            raise _Fault(key, f"{len(words)} values; {count or '1 or more'} axes")
        units = self.units or ("deg",) * len(words)
        return tuple(to_si(_number(key, word, -TURNED, TURNED, unit), unit) for word, unit in zip(words, units, strict=True))

    def block(self, kind: Interpolation, target: Target | Shift, via: PoseTarget | None, keys: dict[str, str], number: int) -> Block:
        parts: dict[str, dict[str, object]] = {"pace": {}, "blend": {}, "curving": {}, "": {}}
        if keys.get("shape") == "trapezoid":
            raise _Fault("shape", "a trapezoid steps the acceleration: the law only of a block with time= (BAHN_ZEIT, ramp=); AX-575")
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
        for name in ("angle", "rise"):
            if name in keys and (kind is not Interpolation.CIRCULAR or "angle" not in keys):
                raise _Fault(name, "belongs to a circular block with angle=")
        if "zone" in keys:
            blend |= {"axes": self.joints("zone", keys["zone"].split(",")), "rounding": Rounding.JOINT}
        if "arcs" in keys:
            blend["past_circles"] = _yes("arcs", keys["arcs"])
        if "lead" in keys:
            parts["pace"]["lead"] = _yes("lead", keys["lead"])
        shift = target if isinstance(target, Shift) else None
        made = Block(
            kind,
            UNKNOWN if isinstance(target, Shift) else target,
            via,
            filled(Pace(), parts["pace"]),
            filled(Blend(), blend),
            self.named("tool", keys, self.tools),
            self.named("frame", keys, self.frames),
            curving=filled(Curving(), parts["curving"]),
            outputs=outputs_of(keys.get("out", "")),
            functions=self.functions,
            until=until_of(keys),
            wait=wait_of(keys),
            synchron=self.part,
            on_belt=self.on_belt(keys),
            alteration=self.altered.part,
            lowest=corner_of("limitmin", keys.get("limitmin", "-")),
            highest=corner_of("limitmax", keys.get("limitmax", "-")),
            shift=shift,
            freeze=self.altered.freeze(keys.get("freeze")),
            ahead=self.ahead,
            system=self.systems.active,
            label=self.labels.label,
            acts=self.acts,
            line=number,
        )
        return filled(made, parts[""])

    def on_belt(self, keys: dict[str, str]) -> OnBelt | None:
        given = [name for name in ("belt", "camin", "camout") if name in keys]
        if given and self.part is None:
            raise _Fault(given[0], "is allowed in a synchronous part only: write synchron BELT before it")
        if given and "belt" not in keys:
            raise _Fault(given[0], "needs the block's value of the belt: belt=")
        return OnBelt(*(length_of(name, keys[name]) if name in keys else 0.0 for name in ("belt", "camin", "camout"))) if given else None

    def named(self, key: str, keys: dict[str, str], known: dict[str, Named]) -> Named:
        name = keys.get(key, "-")
        if name not in known:
            raise _Fault(key, f"{name!r} is unknown; {', '.join(known)} are known")
        return known[name]


BIG = textkeys.BIG
TURNED = 1e7  # places of axes: 9999999.0 is the far target of a balancing machine (rho 3 L6844)
RELATIVE = (Interpolation.PTP, Interpolation.LINEAR)  # MOVE_REL (rho 3)
NO_WAY = ["rel", "pose", *["0"] * 6]
HEADINGS = ("program", "robot", "angles", "axes", "start")
FUNCTIONS: dict[str, Callable[[str, list[str]], Called]] = {
    "iol": function_of,
    "ppo": function_of,
    **MEASURING,
}  # begin with a block
ACTS = ("sync", *CALLS, "mach_pos")  # done at rest before one
PARTS = ("synchron", "synchron_end", "alter", "alter_end", *ACTS)
OTHERS = ("tool", "frame", "point", "set", *PARTS, "label", "block_search", *FUNCTIONS, *FILE_HEADS, *SYSTEM_HEADS)
STATEMENTS = (*HEADINGS, *OTHERS, *MOVES)
ACTING = ("out", "until", "within", "error", "wait", "delay", "belt", "camin", "camout", "freeze")
ONCE = ("config", "extra", *ACTING, "time", "weight", "angle", "rise")  # of one block alone


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
        faults.append(TextError(0, "start", "is missing: where the axes are before the first block"))
    if faults:
        raise TextFaults(faults)
    return Program(reader.name, reader.robot, reader.start, tuple(reader.blocks), reader.units, reader.acts, reader.systems.active)
