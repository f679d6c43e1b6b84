"""The text form of programs of several kinematics; one kinematic: motion.program.text.reader.

`kinematic NAME ROBOT` begins the statements about one: angles, axes, start, tool, frame, point, set, as in a program of one robot.
`kinematic NAME` goes back to it.  A move without a name is that of the kinematic named last; `move NAME linear A and NAME ptp B` moves
several together.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from motion.geometry.conventions import CONVENTIONS, convention
from motion.program.blocks import Act, Alteration, Block, Interpolation, JointTarget, MachinePoint, Synchron
from motion.program.errors import TextError, TextFaults
from motion.program.team import Kinematic, Shared, TeamProgram
from motion.program.text import files as textfiles
from motion.program.text.files import HEADS as FILE_HEADS
from motion.program.text.inputs import called
from motion.program.text.labels import Labels
from motion.program.text.reader import ACTS, FUNCTIONS, MOVES, PARTS, Reader
from motion.program.text.systems import HEADS as SYSTEM_HEADS
from motion.program.text.systems import chosen, declared
from motion.program.text.values import search_of
from motion.program.text.words import Fault, name, one, statement
from motion.program.text.writer import acted, heading, parted, places_of, written_move
from motion.rho3.wc import WcFrame
from motion.robot import MOST_KINEMATICS

CALLS = tuple(FUNCTIONS)  # begin with the next block of the kinematic
OWN = ("angles", "axes", "start", "tool", "frame", "point", "set", *FILE_HEADS, *SYSTEM_HEADS, *CALLS)  # statements about one kinematic
STATEMENTS = ("program", "kinematic", *OWN, *PARTS, *MOVES, "move", "label", "block_search")


def several(text: str) -> bool:
    """Whether a text is a program of several kinematics."""
    return any(line.split()[:1] == ["kinematic"] for line in text.splitlines())


@dataclass(slots=True)
class TeamReader:
    """Line by line, as motion.program.text.reader.Reader."""

    name: str = ""
    readers: dict[str, Reader] = field(default_factory=dict)
    now: str = ""  # kinematic named last
    blocks: list[Shared] = field(default_factory=list)
    labels: Labels = field(default_factory=Labels)
    acts: tuple[Act, ...] = ()  # before the next block, or after the last one
    ahead: int = 0  # BLOCK_SEARCH, of all kinematics

    def statement(self, raw: str, number: int = 0) -> None:
        """Read one line; its block, if any, waits for take().  Raise TextError."""
        statement(raw, number, self.line)

    def take(self) -> list[Shared]:
        """Blocks since the last call."""
        blocks, self.blocks = self.blocks, []
        return blocks

    def ended(self) -> None:
        """End the text: labels named by blocks must follow them, and statements that begin with a block must have one.  Raise TextError."""
        self.labels.ended()
        for named, reader in self.readers.items():
            try:
                reader.check_begun()
            except TextError as error:
                raise TextError(error.line, error.key, f"kinematic {named}: {error.what}") from None

    def line(self, words: list[str], number: int) -> None:
        head, rest = words[0], words[1:]
        match head:
            case "program":
                self.name = one(head, rest)
            case "kinematic":
                self.kinematic(rest)
            case "move":
                self.move(rest, number)
            case _ if head in MOVES or head == "move_file":
                self.add({self.now: self.own(self.now, words, number)}, number)
            case _ if head in OWN:
                self.reader(self.now).line(words, number)
            case "label":
                self.labels.line(head, rest, acting=bool(self.acts))
            case _ if head in ACTS:
                self.act(words, number)
            case "synchron" | "synchron_end" | "alter" | "alter_end":
                self.part(words, number)
            case "block_search":
                self.ahead = search_of(head, rest)
            case "robot":
                raise Fault(head, "`kinematic NAME ROBOT` names the robot of each kinematic")
            case _:
                raise Fault(head, f"no statement of a program of several kinematics; {', '.join(STATEMENTS)} are")

    def kinematic(self, rest: list[str]) -> None:
        if not 1 <= len(rest) <= 2:
            raise Fault("kinematic", "kinematic NAME ROBOT, or only NAME to return to it")
        self.now = name("kinematic", rest[0])
        if len(rest) == 1 and self.now not in self.readers:
            raise Fault("kinematic", f"{self.now!r} is unknown: write kinematic NAME ROBOT, with its robot file, first")
        if len(rest) == 2:
            if self.now in self.readers:
                raise Fault("kinematic", f"{self.now} has a robot already")
            if self.labels.blocks:
                raise Fault("kinematic", f"{self.now} must be before the first move")
            if len(self.readers) == MOST_KINEMATICS:
                raise Fault("kinematic", f"at most {MOST_KINEMATICS} kinematics in one cell")
            self.readers[self.now] = Reader(robot=rest[1])

    def reader(self, named: str) -> Reader:
        if named not in self.readers:
            known = ", ".join(self.readers) or "none: write `kinematic NAME ROBOT` first"
            raise Fault("kinematic", f"{named!r} is unknown; {known}" if named else known)
        return self.readers[named]

    def move(self, rest: list[str], number: int) -> None:
        """NAME MOVE .. and NAME MOVE .. ."""
        parts: list[list[str]] = [[]]
        for word in rest:
            if word == "and":
                parts.append([])
            else:
                parts[-1].append(word)
        moves: dict[str, Block] = {}
        for part in parts:
            if part[1:2] == ["move_file"]:
                raise Fault("move_file", f"only one kinematic runs a file, in its own line: kinematic {part[0]}, then move_file ..")
            if len(part) < 2 or part[1] not in MOVES:
                raise Fault("move", f"NAME and one of {', '.join(MOVES)}, then its target; `and` between two kinematics")
            if part[0] in moves:
                raise Fault("move", f"{part[0]} is used twice in one block")
            moves[part[0]] = self.own(part[0], part[1:], number)
        self.add(moves, number)

    def own(self, named: str, words: list[str], number: int) -> Block:
        """One kinematic's part of a block."""
        (block,) = self.said(named, words, number).take()
        return replace(block, ahead=self.ahead)

    def said(self, named: str, words: list[str], number: int) -> Reader:
        """The reader of a kinematic; it was given this line."""
        reader = self.reader(named)
        try:
            reader.line(words, number)
        except Fault as fault:
            raise Fault(fault.key, f"kinematic {named}: {fault.what}") from None
        return reader

    @property
    def inside(self) -> bool:
        """Of a synchronous or alterable part of one of them."""
        return self.alone != ""

    @property
    def alone(self) -> str:
        """Name of the kinematic in a belt or alterable part; only this one moves."""
        return next((each for each, reader in self.readers.items() if reader.inside), "")

    def part(self, words: list[str], number: int) -> None:
        """One is on a belt, or corrected, from here on, or no longer; parts are counted over all of them."""
        reader = self.reader(self.now)
        self.check_alone(words[0], (self.now,))
        reader.parts = max(each.parts for each in self.readers.values())
        reader.altered.count = max(each.altered.count for each in self.readers.values())
        for block in self.said(self.now, words, number).take():  # after a SYNC that is the last statement of its part
            self.add({self.now: replace(block, ahead=self.ahead)}, number)

    def check_alone(self, key: str, moving: Iterable[str]) -> None:
        """What others do waits for the end of the part that one of them is in."""
        if self.alone and (others := [each for each in moving if each != self.alone]):
            what = "alter_end" if self.readers[self.alone].altered.part is not None else "synchron_end"
            raise Fault(
                key, f"kinematic {self.alone} is on a belt or corrected and moves alone, {', '.join(others)} cannot: write {what} first"
            )

    def act(self, words: list[str], number: int) -> None:
        """Read an action at rest before the next block of any of them, a machine position for the kinematic named last; inside a part it
        belongs to the next block of the part.
        """
        self.check_alone(words[0], (self.now,))
        reader, place = self.said(self.now, words, number), list(self.readers).index(self.now)
        own = [replace(each, member=place) if isinstance(each, MachinePoint) else each for each in reader.acts]
        reader.acts = tuple(each for each in own if each.inside and not isinstance(each, MachinePoint))
        self.acts += tuple(each for each in own if each not in reader.acts)

    def add(self, moves: dict[str, Block], number: int) -> None:
        self.check_alone("move", moves)
        shared = Shared(tuple(moves.get(each) for each in self.readers), number, self.labels.label, self.acts)
        self.blocks.append(shared)
        for asked in {block.goes_on_at for block in shared.own}:
            self.labels.asked(number, asked)
        self.labels.added()
        self.acts = ()

    def kinematics(self) -> tuple[Kinematic, ...]:
        named = {id(each): word for word, each in reversed(CONVENTIONS.items())}
        return tuple(
            Kinematic(each, reader.robot, reader.start, reader.units, named[id(reader.angles)]) for each, reader in self.readers.items()
        )


def read_team(text: str) -> TeamProgram:
    """The program of a text; raises TextFaults with every fault in it."""
    reader, faults = TeamReader(), []
    for number, raw in enumerate(text.splitlines(), 1):
        try:
            reader.statement(raw, number)
        except TextError as error:
            faults.append(error)
    try:
        reader.ended()
    except TextError as error:
        faults.append(error)
    faults += [
        TextError(0, "start", f"is missing: where the axes of kinematic {each} are before the first block")
        for each, own in reader.readers.items()
        if not own.start
    ]
    if faults:
        raise TextFaults(faults)
    return TeamProgram(reader.name, reader.kinematics(), tuple(reader.blocks), reader.acts)


def write_team(program: TeamProgram) -> str:
    """The text of a program; raises MotionError where one name is used for two tools or frames of one kinematic."""
    lines = [f"program {program.name}"] if program.name else []
    for n, each in enumerate(program.kinematics):
        own = [block for shared in program.blocks if (block := shared.moves[n]) is not None]
        lines.append(f"kinematic {each.name} {each.robot}")
        lines += heading(each.start, each.units, each.angles)
        references = [block.alteration.reference for block in own if block.alteration is not None]
        lines += places_of(own, convention(each.angles), references)
        lines += declared(block.system for block in own)
    systems: dict[str, WcFrame | None] = {}
    files: dict[str, dict[str, int]] = {each.name: {} for each in program.kinematics}
    ahead = 0
    under_way: tuple[str, Block] | None = None  # the kinematic in a part, and its last block
    for shared in program.blocks:
        lines += _part_ends(program, under_way, shared)
        if (now := max((block.ahead for block in shared.own), default=0)) != ahead:
            ahead = now
            lines.append(f"block_search {ahead or '-'}")
        lines += [f"label {shared.label}"] if shared.label else []
        lines += _acts(program, shared.acts)
        lines += _part_begins(program, under_way, shared)
        under_way = None if shared.alone is None else (program.kinematics[shared.alone[0]].name, shared.alone[1])
        parts = []
        for each, block in zip(program.kinematics, shared.moves, strict=True):
            lines += [f"kinematic {each.name}", *map(called, block.functions)] if block is not None and block.functions else []
        for each, block in zip(program.kinematics, shared.moves, strict=True):
            if block is not None:
                if block.system != systems.get(each.name):
                    lines += [f"kinematic {each.name}", chosen(block.system)]
                    systems[each.name] = block.system
                if block.file is not None:
                    lines += [f"kinematic {each.name}", *textfiles.written(block.file, files[each.name])]
                    continue
                units = each.units or ("deg",) * len(each.start)
                parts.append(f"{each.name} {written_move(block, convention(each.angles), units)}")
        lines += [f"move {' and '.join(parts)}"] if parts else []
    asked = {block.goes_on_at for shared in program.blocks for block in shared.own} - {""}
    lines += [f"label {name}" for name in sorted(asked - {shared.label for shared in program.blocks})]
    ended = ["synchron_end"] if under_way is not None and under_way[1].synchron is not None and program.acts else []
    return "\n".join([*lines, *ended, *_acts(program, program.acts)]) + "\n"


def _of_part(under_way: tuple[str, Block] | None, name: str) -> tuple[Synchron | None, Alteration | None]:
    """Parts that this kinematic is in."""
    return (None, None) if under_way is None or under_way[0] != name else (under_way[1].synchron, under_way[1].alteration)


def _part_ends(program: TeamProgram, under_way: tuple[str, Block] | None, shared: Shared) -> list[str]:
    """Lines that end the part of one of them, where this block does not belong to it."""
    if under_way is None:
        return []
    place = next(n for n, each in enumerate(program.kinematics) if each.name == under_way[0])
    following = shared.alone[1] if shared.alone is not None and shared.alone[0] == place else Block(Interpolation.PTP, JointTarget(()))
    ends, _ = parted(*_of_part(under_way, under_way[0]), following)
    return [f"kinematic {under_way[0]}", *ends] if ends else []


def _part_begins(program: TeamProgram, under_way: tuple[str, Block] | None, shared: Shared) -> list[str]:
    """Return the lines that begin the part of the moving kinematic, and those inside the part before its block."""
    if shared.alone is None:
        return []
    member, block = shared.alone
    each = program.kinematics[member]
    _, begin = parted(*_of_part(under_way, each.name), block)
    own = shared.moves[member]
    said = [acted(act, each.units or ("deg",) * len(each.start)) for act in (own.acts if own is not None else ())]
    return [f"kinematic {each.name}", *begin, *said] if begin or said else []


def _acts(program: TeamProgram, acts: tuple[Act, ...]) -> list[str]:
    """Return the lines of actions at rest, each with its kinematic."""
    lines = []
    for act in acts:
        each = program.kinematics[act.member if isinstance(act, MachinePoint) else 0]
        lines += [f"kinematic {each.name}", acted(act, each.units or ("deg",) * len(each.start))]
    return lines
