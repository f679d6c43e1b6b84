"""What standard operation shows in each mode of the pendant: a title and rows to scroll through (AX-495)."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Protocol

from gateway.pure.controllers.rho3.functions.display import COLUMNS
from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.controllers.rho3.functions.processes import Process, ProcessFault, ProcessTable
from gateway.pure.controllers.rho3.pendant.infos import Condition
from gateway.pure.controllers.rho3.pendant.modes import MODES, RESET, Mode, spoken
from gateway.pure.controllers.rho3.pendant.user_memory import PointFile
from gateway.pure.image.records.interpreter import Fact
from motion.program.factors import Factors

DEFINE: Mode = (4, 1)
TEACH: Mode = (4, 2)
FACTOR_MODES: dict[Mode, str] = {(11, 4): "velocity", (11, 5): "acceleration", (11, 6): "deceleration"}


class Source(Protocol):
    """The control as the pendant asks it."""

    @property
    def processes(self) -> ProcessTable:
        """Programs and processes."""

    @property
    def factors(self) -> Factors:
        """The global ones."""

    def set_factor(self, which: str, value: float, kinematic: int = 0) -> None:
        """velocity | acceleration | deceleration, 0..1; kinematic 0: the global one."""

    def positions(self) -> Sequence[tuple[str, str, float]]:
        """Axes: name, unit, actual position in it."""

    def faults(self) -> Sequence[tuple[int, str]]:
        """Errors and warnings, first one first: code, words."""

    def automatic(self) -> Sequence[bool]:
        """Operating mode of each kinematic."""

    def manual(self) -> Sequence[int]:
        """Numbers of the kinematics in manual."""

    def concerned(self) -> Sequence[int]:
        """Numbers of the kinematics that INFO names."""

    def fast_inputs(self) -> Sequence[str]:
        """Servo boards with high-speed inputs: number and the state of each."""

    def conditions(self) -> Collection[Condition]:
        """Content of INFO."""

    def start(self, name: str) -> object:
        """A program; ProcessFault."""

    def order_memory(self, what: str) -> str:
        """Save to the EEPROM, load from there; why it is refused at once."""

    def memory_outcome(self, what: str) -> str | None:
        """Return its outcome; None: still running, or not ordered."""

    def entered(self, mode: Mode) -> int:
        """A mode is selected; the row it begins with."""

    def point_files(self) -> Sequence[str]:
        """Names of the PKT files of the user memory."""

    def point_file(self) -> PointFile | None:
        """The one that modes 4.1 and 4.2 show."""

    def open_points(self, file: str) -> str:
        """It is to be shown; why it is not."""

    def teach(self, file: str, point: str) -> str:
        """The actual position becomes this point; why it is refused at once."""

    def define(self, shown: PointFile, point: str, place: int, size: int, value: float) -> str:
        """A component of a point gets a number; why it is refused at once."""

    def component(self, shown: PointFile, point: str, place: int, size: int) -> str:
        """Its value; - for none."""

    def taught(self, file: str, point: str) -> str | None:
        """What became of it: empty, why it was refused, None: this point was not taught last."""

    def print_points(self, file: str) -> str:
        """Mode 9.4.2; why it is refused at once."""

    def refusal(self) -> str:
        """Why an EPROM backup was refused, once; empty: none was."""

    def parameters(self) -> Sequence[tuple[str, str]]:
        """Machine parameters of the cell: name, value."""

    def locked(self) -> bool:
        """Whether they need a password that has not been entered in this selection of the mode."""

    def unlock(self, password: str) -> bool:
        """Whether it is the one."""

    def movement(self) -> bool:
        """Whether tests move."""

    def order_test(self, what: str, **facts: Fact) -> None:
        """To the test system."""

    def tested(self) -> Sequence[tuple[int, str, int, bool]]:
        """Processes of the test: run, program, line, whether it is held."""


def _nothing(row: int) -> str:
    return ""


def _no_number(text: str, row: int) -> str:
    return ""


@dataclass(frozen=True, slots=True)
class Page:
    """`choose(row)` is ENTER on a row, `put(text, row)` ENTER after a number where `edits`; they return the message."""

    title: str
    rows: tuple[str, ...] = ()
    choose: Callable[[int], str] = _nothing
    edits: bool = False
    put: Callable[[str, int], str] = _no_number
    asks: Callable[[int], str] = _nothing  # a question before `choose`; a second ENTER is yes
    secret: bool = False  # the entry is not shown, and any key after the question begins it
    note: Callable[[int], str] = _nothing  # what became of the last choice in a row


def page_of(mode: Mode, source: Source, language: str) -> Page:
    """The page of a mode that exists."""
    title = f"{spoken(mode)} {MODES[mode]}" if mode in MODES else say("phg_basic", language)
    if mode == RESET:
        return Page(title, (say("phg_done", language),))
    if mode in FACTOR_MODES:
        return _factor(title, FACTOR_MODES[mode], source, language)
    match mode:
        case ():
            every = all(source.automatic())
            return Page(title, (say("phg_automatic" if every else "phg_manual", language),))
        case (7, 1):
            return Page(title, tuple(f"{name:<4}{actual:>12.3f} {unit:<3}"[:COLUMNS] for name, unit, actual in source.positions()))
        case (7, 2) | (7, 13):
            return _listed(title, mode, source, language)
        case (7, 3, 2):
            rows = tuple(row for each in source.processes.processes for row in _process(each, language))
            return Page(title, rows or (say("phg_no_process", language),))
        case (7, 3, 3):
            words = (say("phg_manual", language), say("phg_automatic", language))
            return Page(title, tuple(f"Kin. {n}: {words[auto]}" for n, auto in enumerate(source.automatic(), 1)))
        case _ if mode in ORDERING:
            return ORDERING[mode](title, mode, source, language)
    below = tuple(f"{each[-1]} {name}" for each, name in MODES.items() if each[:-1] == mode)
    return Page(title, below or (say("phg_not_here", language),))


def _process(process: Process, language: str) -> tuple[str, ...]:
    """Its state; below it what it waits for and another process has, and that process with its line (AX-1731)."""
    state = say("STUCK" if process.stuck else process.state.name, language)
    rows = [f"{process.name:<11} {state}"]
    if process.holder:
        rows += [f" {process.wants.removeprefix('semaphore ')}", say("held_by", language, process.holder.replace(" line ", " "))]
    return tuple(row[:COLUMNS] for row in rows)


def _listed(title: str, mode: Mode, source: Source, language: str) -> Page:
    """Errors, or boards with their high-speed inputs."""
    if mode == (7, 13):
        return Page(title, tuple(source.fast_inputs()) or (say("phg_no_board", language),))
    rows = tuple(f"{code:>4} {words}"[:COLUMNS] for code, words in source.faults())
    return Page(title, rows or (say("phg_no_error", language),))


def _start(title: str, mode: Mode, source: Source, language: str) -> Page:
    names = sorted(name for name in source.processes.programs if source.processes.named(name) is None)

    def choose(row: int) -> str:
        if not names:
            return ""
        name = names[row % len(names)]
        try:
            source.start(name)
        except ProcessFault as fault:
            return f"{name} {fault.code}"
        return say("phg_started", language)

    return Page(title, tuple(names) or (say("phg_no_program", language),), choose)


def _stop(title: str, mode: Mode, source: Source, language: str) -> Page:
    processes = source.processes.processes

    def choose(row: int) -> str:
        return say("phg_stopped", language) if processes and source.processes.stop(processes[row % len(processes)].number) else ""

    return Page(title, tuple(each.name for each in processes) or (say("phg_no_process", language),), choose)


def _eeprom(title: str, mode: Mode, source: Source, language: str) -> Page:
    """9.6, 9.7: ENTER carries it out; then how it ended."""
    what = "save" if mode == (9, 6) else "load"
    outcome = source.memory_outcome(what)
    row = say("phg_execute", language) if outcome is None else outcome or say("phg_done", language)
    return Page(title, (row,), lambda _: source.order_memory(what))


def _card(title: str, mode: Mode, source: Source, language: str) -> Page:
    """9.8: a second ENTER confirms it (L11452-11472)."""
    outcome = source.memory_outcome("init")
    row = say("phg_execute", language) if outcome is None else outcome or say("phg_done", language)
    return Page(title, (row,), lambda _: source.order_memory("init"), asks=lambda _: say("phg_sure", language))


def _parameters(title: str, mode: Mode, source: Source, language: str) -> Page:
    """7.8.2: a parameter that is protected is opened by the password (L5036-5052)."""
    found = source.parameters()
    if not found:
        return Page(title, (say("phg_no_parameter", language),))

    def opened(row: int) -> str:
        return found[row % len(found)][1]

    def enter(password: str, _: int) -> str:
        return "" if source.unlock(password) else say("phg_enter_password", language)

    names = tuple(name for name, _ in found)
    if source.locked():
        return Page(title, names, edits=True, put=enter, asks=lambda _: say("phg_enter_password", language), secret=True)
    return Page(title, names, opened)


def _tested(title: str, mode: Mode, source: Source, language: str) -> Page:
    """5.9: ENTER runs the next line of the process in the row; 5.10: ENTER switches, for all kinematics."""
    if mode == (5, 10):

        def switch(_: int) -> str:
            source.order_test("movement", on=not source.movement())
            return ""

        return Page(title, (say("phg_with" if source.movement() else "phg_without", language),), switch)
    tests = source.tested()

    def step(row: int) -> str:
        if tests:
            run, _, _, held = tests[row % len(tests)]
            source.order_test("step", run=run, how="into" if held else "hold")
        return ""

    rows = tuple(f"{name:<8} {line:>5} {say('phg_held', language) if held else ''}"[:COLUMNS] for _, name, line, held in tests)
    return Page(title, rows or (say("phg_no_process", language),), step)


def _points(title: str, mode: Mode, source: Source, language: str) -> Page:
    """4.1, 4.2: ENTER opens a file; then 4.1 accepts numbers for the components of points, 4.2 stores the actual position (L4768-4844)."""
    shown, files = source.point_file(), source.point_files()
    if shown is not None:
        points = shown.points
        head = f"{spoken(mode)} {shown.name}"
        if mode == TEACH and points:
            return _teaching(head, shown, source, language)
        return _defining(head, shown, source, language)
    return Page(
        title, tuple(files) or (say("phg_no_points", language),), lambda row: source.open_points(files[row % len(files)]) if files else ""
    )


def _defining(head: str, shown: PointFile, source: Source, language: str) -> Page:
    """A row for each component, its value below it; a number and ENTER store it (L9912-10070)."""
    places = range(len(shown.points))
    rows = [(shown.points[at][0], place, shown.components(at)) for at in places for place in range(shown.components(at))]

    def note(row: int) -> str:
        name, place, size = rows[row % len(rows)]
        outcome = source.taught(shown.name, name)
        return outcome or source.component(shown, name, place, size)

    def put(text: str, row: int) -> str:
        name, place, size = rows[row % len(rows)]
        try:
            number = float(text)
        except ValueError:
            return say("phg_no_value", language)
        return source.define(shown, name, place, size, number)

    shown_rows = tuple(f"{name[: COLUMNS - 3]}.{place + 1}" for name, place, _ in rows)
    return Page(head, shown_rows, edits=bool(rows), put=put if rows else _no_number, note=note)


def _teaching(head: str, shown: PointFile, source: Source, language: str) -> Page:
    """A point that is defined is overwritten after a question, in the words of L4836."""

    def named(row: int) -> tuple[str, str]:
        return shown.points[row % len(shown.points)]

    def note(row: int) -> str:
        outcome = source.taught(shown.name, named(row)[0])
        return "" if outcome is None else outcome or say("phg_taught", language)

    return Page(
        head,
        tuple(f"{name:<13}{'' if values else '-'}".rstrip() for name, values in shown.points),
        lambda row: source.teach(shown.name, named(row)[0]),
        asks=lambda row: say("phg_overwrite", language) if named(row)[1] else "",
        note=note,
    )


def _print(title: str, mode: Mode, source: Source, language: str) -> Page:
    """9.4.2: ENTER prints an entire file; one that special function 16 has selected is the only one offered (L10776-10833)."""
    shown = source.point_file()
    files = [shown.name] if shown is not None else list(source.point_files())

    def note(_: int) -> str:
        outcome = source.memory_outcome("print")
        return "" if outcome is None else outcome or say("phg_done", language)

    rows = tuple(files) or (say("phg_no_points", language),)
    return Page(title, rows, lambda row: source.print_points(files[row % len(files)]) if files else "", note=note)


def _factor(title: str, which: str, source: Source, language: str) -> Page:
    """V, A, D: 1.0 is 100 % (L2671-2681)."""

    def put(text: str, _: int) -> str:
        try:
            value = float(text)
        except ValueError:
            value = -1.0
        if not 0.0 <= value <= 1.0:
            return say("phg_factor_range", language)
        source.set_factor(which, value)
        return say("phg_done", language)

    return Page(title, (f"{getattr(source.factors, which):.3f}",), edits=True, put=put)


ORDERING: dict[Mode, Callable[[str, Mode, Source, str], Page]] = {
    DEFINE: _points, TEACH: _points, (5, 9): _tested, (5, 10): _tested,
    (7, 8, 2): _parameters, (9, 4, 2): _print, (9, 6): _eeprom, (9, 7): _eeprom, (9, 8): _card, (10, 1): _start, (10, 2): _stop,
}  # fmt: skip
