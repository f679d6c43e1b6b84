"""Translates a start program and all that it calls, with the checks of the start.  Source: robotstar 5.4, L2314-2321, L2753-2791."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.base.faults import Faults, also_at, hints
from gateway.pure.languages.base.near import MOST_HINTS, hint_for_print
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.plc.commands import CALLS, JUMPS, OPENERS, Code, Command, Program, Routine
from gateway.pure.languages.plc.reader import read_routine

DEPTH = 16
MOST_COMMANDS = 250_000
NO_START, FULL, DEEP = "Start program doesn't exist", "Program memory is full", "Nesting depth too big"
NO_PROGRAM, BRACKETS = "Subprogram not found", "Incorrect parentheses"
NO_LABEL, TWO_LABELS = "Branch destination not defined", "Multiple definition of label"
Reader = Callable[[str, str, Faults], tuple[Routine, dict[int, int]]]


def key_of(name: str) -> str:
    """A name as the control compares it: without case, `/` between directories."""
    return name.strip().replace("\\", "/").upper()


def start_name(path: str, start: str) -> str:
    """_SPLC_PATH and _SSTARTPLC as one name; empty: a name that begins with a blank, or none (L2371-2394, L2865-2877)."""
    name = "" if not start or start[0].isspace() else start.split(maxsplit=1)[0]
    return f"{path.strip().rstrip('/')}/{name}" if name and path.strip() else name


def start_in_folder(name: str, folder: str = "S:/PLC") -> str:
    """A name of start_name as one in the folder of the PLC's programs; ValueError: it lies elsewhere."""
    key, root = key_of(name), key_of(folder)
    if not key or "/" not in key:
        return key
    for prefix in (f"{root}/", f"{root.removeprefix('S:')}/"):
        if key.startswith(prefix):
            return key.removeprefix(prefix)
    raise ValueError(f"{name}: the programs of this PLC are in {folder}")


@dataclass(slots=True)
class Translation:
    """One run over the sources.  `lines` returns the line of a step in its file."""

    sources: Mapping[str, str]
    reader: Reader = read_routine
    faults: Faults = field(default_factory=Faults)
    lines: dict[str, dict[int, int]] = field(default_factory=dict)
    _texts: dict[str, str] = field(default_factory=dict)
    _ready: dict[str, Routine] = field(default_factory=dict)
    _depths: dict[str, int] = field(default_factory=dict)

    def run(self, start: str) -> Program | None:
        """The program; None: there are faults."""
        key = key_of(start)
        if not key or key not in self._texts:
            known = ", ".join(sorted(self.sources)[:8]) or "none"
            self.faults.error("no-start", Position(start.strip() or "PLC", 1), NO_START, f"programs found: {known}")
            return None
        self._follow(key, [])
        program = Program(key, dict(self._ready))
        if not self.faults.errors and program.size > MOST_COMMANDS:
            self.faults.error("memory", Position(key, 1), FULL, f"{program.size} commands, at most {MOST_COMMANDS}")
        return None if self.faults.errors else program

    def check_all(self) -> Faults:
        """Faults of all sources, whether a start program reaches them or not."""
        for key in sorted(self._texts):
            self._follow(key, [])
        return self.faults

    def __post_init__(self) -> None:
        self._texts = {key_of(name): text for name, text in self.sources.items()}

    def _follow(self, key: str, above: list[str]) -> int:
        """Reads a routine and those it calls, these first; the depth of calls under it."""
        if key in self._depths:
            return self._depths[key]
        routine, self.lines[key] = self.reader(key, self._texts[key], self.faults)
        check_labels(routine, self._place, self.faults)
        deepest = 0
        missing: dict[str, list[int]] = {}
        for command in routine.commands:
            if command.code not in CALLS:
                continue
            target = self._target(key, command)
            if target is None:
                missing.setdefault(command.name, []).append(command.line)
                continue
            if target == key or target in above:
                self.faults.error("depth", self._place(key, command.line), DEEP, f"{command.name} calls itself")
            elif len(above) >= DEPTH and target not in self._depths:
                self.faults.error("depth", self._place(key, command.line), DEEP, f"{DEPTH} levels of SU at most")
            else:
                deepest = max(deepest, 1 + self._follow(target, [*above, key]))
                if deepest > DEPTH:
                    self.faults.error("depth", self._place(key, command.line), DEEP, f"{DEPTH} levels of SU at most")
                    deepest = 0
        for name, steps in missing.items():
            hint = "SU calls programs of the same directory" if "/" in name else f"{name} is not in the directory"
            folder = key.rpartition("/")[0]
            others = [other.rpartition("/")[2] for other in self._texts if other.rpartition("/")[0] == folder and other != key]
            near = hint_for_print(name, others) if len(self.faults) < MOST_HINTS else ""
            self.faults.error("subprogram", self._place(key, steps[0]), NO_PROGRAM, hints(hint, near, also_at(steps[1:])))
        self._depths[key] = deepest
        self._ready[key] = Routine(key, tuple(self._resolved(key, command) for command in routine.commands), routine.last)
        return deepest

    def _target(self, key: str, command: Command) -> str | None:
        folder = key.rpartition("/")[0]
        target = f"{folder}/{command.name}" if folder else command.name
        return None if "/" in command.name or target not in self._texts else target

    def _resolved(self, key: str, command: Command) -> Command:
        folder = key.rpartition("/")[0]
        if command.code not in CALLS or not folder:
            return command
        return Command(command.code, command.line, name=f"{folder}/{command.name}")

    def _place(self, key: str, step: int) -> Position:
        return Position(key, self.lines.get(key, {}).get(step, step))


def check_labels(routine: Routine, place: Callable[[str, int], Position], faults: Faults) -> None:
    """Labels and brackets of a routine: each label once, each jump to a label in the same bracket, each bracket closed and not empty."""
    labels, jumps = _groups(routine, place, faults)
    lost: dict[str, list[int]] = {}
    for command, group in jumps:
        where = place(routine.name, command.line)
        if command.name not in labels:
            lost.setdefault(command.name, []).append(command.line)
        elif labels[command.name] != group:
            faults.error("brackets", where, BRACKETS, f"the jump to {command.name} leaves or enters a bracket")
    for at, (name, steps) in enumerate(lost.items()):
        near = hint_for_print(name, [*labels]) if at < MOST_HINTS else ""
        faults.error("label", place(routine.name, steps[0]), NO_LABEL, hints(f"there is no M {name}", near, also_at(steps[1:])))


def _groups(
    routine: Routine, place: Callable[[str, int], Position], faults: Faults
) -> tuple[dict[str, tuple[int, ...]], list[tuple[Command, tuple[int, ...]]]]:
    """Labels and jumps with the brackets open at them."""
    labels: dict[str, tuple[int, ...]] = {}
    jumps: list[tuple[Command, tuple[int, ...]]] = []
    opened: list[int] = []
    for at, command in enumerate(routine.commands):
        if command.code in OPENERS:
            opened.append(at)
        elif command.code is Code.CLOSE:
            if not opened or opened.pop() == at - 1:
                faults.error("brackets", place(routine.name, command.line), BRACKETS, "this ')' does not close a bracket, or an empty one")
        elif command.code is Code.LABEL:
            if command.name in labels:
                faults.error("two-labels", place(routine.name, command.line), TWO_LABELS, f"M {command.name} exists twice")
            labels.setdefault(command.name, tuple(opened))
        elif command.code in JUMPS:
            jumps.append((command, tuple(opened)))
    for at in opened:
        faults.error("brackets", place(routine.name, routine.commands[at].line), BRACKETS, "this bracket is not closed")
    return labels, jumps
