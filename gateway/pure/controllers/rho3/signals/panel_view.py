"""The control as its pendant asks it (gateway.pure.controllers.rho3.pendant.pages.Source)."""

from collections.abc import Collection, Sequence

from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.controllers.rho3.functions.processes import ProcessTable
from gateway.pure.controllers.rho3.pendant.infos import Condition, conditions_of
from gateway.pure.controllers.rho3.pendant.modes import Mode
from gateway.pure.controllers.rho3.pendant.pages import DEFINE, TEACH
from gateway.pure.controllers.rho3.pendant.user_memory import PointFile
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.control_state import ControlState
from gateway.pure.controllers.rho3.signals.errors import RHO3
from gateway.pure.image.records.cell import EVERY_AXIS, AxisFlag
from gateway.pure.image.records.interpreter import Fact
from motion.program.factors import Factors

TEST_MN = "TEST_MN_RCI"
POINT_MODES: tuple[Mode, ...] = (DEFINE, TEACH, (9, 4, 2))
NO_PRINTER, PRINTER_DISABLED = "Interface: n.avail.", "DISPRINT_RCI"


class PanelView:
    """Reads one control; starts programs and sets factors as the operator at the pendant may."""

    def __init__(self, control: ControlState) -> None:
        self._control, self._refusal = control, ""

    @property
    def processes(self) -> ProcessTable:
        return self._control.processes

    @property
    def factors(self) -> Factors:
        return self._control.factor_table.global_factors()

    def set_factor(self, which: str, value: float, kinematic: int = 0) -> None:
        self._control.set_factor(which, value, kinematic)

    def positions(self) -> Sequence[tuple[str, str, float]]:
        setup = self._control.setup
        places = zip(setup.axes, setup.units, self._control.cell.axes, strict=False)
        return [(name, unit, axis.actual * factor) for name, (unit, factor), axis in places]

    def faults(self) -> Sequence[tuple[int, str]]:
        language = self._control.setup.functions.language
        records = self._control.errors.records
        return [(each.code, f"{code_text(each.code, language)} {each.where}".strip()) for each in records if each.source == RHO3]

    def automatic(self) -> Sequence[bool]:
        control = self._control
        return [control.modes.automatic(number + 1) for number in range(control.setup.installation.kinematics)]

    def manual(self) -> Sequence[int]:
        return [number for number, automatic in enumerate(self.automatic(), 1) if not automatic]

    def fast_inputs(self) -> Sequence[str]:
        return self._control.channels.fast.shown()

    def conditions(self) -> Collection[Condition]:
        control = self._control
        bits = control.setup.info_bits
        axes = control.cell.axes[: len(control.setup.axes)]
        return conditions_of(
            lambda name: name in bits and control.image.input(bits[name]),
            referenced=all(axis.flags & AxisFlag.REFERENCED for axis in axes),
            in_position=all(axis.flags & AxisFlag.IN_POSITION for axis in axes),
            test=bits.get(TEST_MN, 0) > 0 and control.image.input(bits[TEST_MN]),
            withheld=control.cell.withheld(EVERY_AXIS),
        )

    def concerned(self) -> Sequence[int]:
        """Kinematics in manual, and those that their own feed inputs hold."""
        held = {number for number, lane in enumerate(self._control.cell.lanes, 1) if lane.withheld}
        return sorted(held | set(self.manual()))

    def order_memory(self, what: str) -> str:
        """Modes 9.6, 9.7 and 9.8; why it is refused at once."""
        control = self._control
        if control.hosted is None:
            return "Option not found"
        active = bool(control.processes.processes)
        control.memory.ordered = what, control.hosted.order(what, stop=not control.closed, active=active)
        return ""

    def memory_outcome(self, what: str) -> str | None:
        """Return its outcome; None: still running, or not ordered."""
        control = self._control
        ordered, ticket = control.memory.ordered
        return control.hosted.answers.get(ticket) if control.hosted is not None and ordered == what else None

    def memory_done(self) -> bool:
        """Return whether an order was executed after which the control starts up."""
        memory, what = self._control.memory, self._control.memory.ordered[0]
        outcome = self.memory_outcome(what) if what not in ("", "print") else None
        if what == "backup" and outcome:
            memory.ordered, self._refusal = ("", 0), outcome
        elif what == "backup" and outcome == "" and memory.error_code:
            self._control.errors.drop(memory.error_code, "", RHO3)
            memory.system_error = 0
        return outcome == ""

    def refusal(self) -> str:
        why, self._refusal = self._refusal, ""
        return why

    def entered(self, mode: Mode) -> int:
        row = self._control.memory.enter(points=mode in POINT_MODES)
        shown = self._control.memory.opened
        return row if mode != DEFINE or shown is None else sum(shown.components(place) for place in range(row))

    def point_files(self) -> Sequence[str]:
        return [each.name for each in self._control.memory.files if each.name.endswith(".PKT")]

    def point_file(self) -> PointFile | None:
        return self._control.memory.opened

    def open_points(self, file: str) -> str:
        if self._control.hosted is None:
            return "Option not found"
        self._control.hosted.order("points", file=file)
        return ""

    def teach(self, file: str, point: str) -> str:
        """Mode 4.2; why it is refused at once."""
        control = self._control
        if control.hosted is None:
            return "Option not found"
        if Condition.DEFINE_DISABLED in self.conditions():
            return Condition.DEFINE_DISABLED.value
        program = file.removesuffix(".PKT")
        row = next((row for row in control.hosted.programs if row["name"] == program), None)
        given = row["kinematics"] if row is not None else None
        own = min(given) if isinstance(given, list) and given else 1
        if own not in self.manual():
            return say("phg_not_manual", control.setup.functions.language)
        control.memory.taught = file, point, control.hosted.order("teach", program=program, point=point, kinematic=0)
        return self.open_points(file)  # as it is then

    def define(self, shown: PointFile, point: str, place: int, size: int, value: float) -> str:
        """Mode 4.1; a point that is not defined is stored when all of its components are there."""
        control = self._control
        if control.hosted is None:
            return "Option not found"
        if Condition.DEFINE_DISABLED in self.conditions():
            return Condition.DEFINE_DISABLED.value
        typed = control.memory.typed.setdefault((shown.name, point), {})
        typed[place] = value
        values = [self.component(shown, point, each, size) for each in range(size)]
        if "-" in values:
            return ""
        del control.memory.typed[shown.name, point]
        order = control.hosted.order("define", program=shown.name.removesuffix(".PKT"), point=point, value=" ".join(values))
        control.memory.taught = shown.name, point, order
        return self.open_points(shown.name)

    def component(self, shown: PointFile, point: str, place: int, size: int) -> str:
        """As it was typed, else as it is stored."""
        typed = self._control.memory.typed.get((shown.name, point), {})
        values = dict(shown.points).get(point, "").split()
        return f"{typed[place]:.10g}" if place in typed else values[place] if place < len(values) else "-"

    def taught(self, file: str, point: str) -> str | None:
        """What became of it."""
        *place, ticket = self._control.memory.taught
        hosted = self._control.hosted
        return hosted.answers.get(ticket) if hosted is not None and place == [file, point] else None

    def print_points(self, file: str) -> str:
        """Mode 9.4.2; why it is refused at once."""
        control = self._control
        bit = control.setup.info_bits.get(PRINTER_DISABLED, 0)
        if bit and control.image.input(bit):
            return Condition.PRINTER_DISABLED.value
        if control.hosted is None:
            return NO_PRINTER
        control.memory.ordered = "print", control.hosted.order("print", file=file, stop=False, active=False)
        return ""

    def parameters(self) -> Sequence[tuple[str, str]]:
        return self._control.setup.parameters

    def locked(self) -> bool:
        return bool(self._control.setup.password) and not self._control.memory.unlocked

    def unlock(self, password: str) -> bool:
        self._control.memory.unlocked = password == self._control.setup.password
        return self._control.memory.unlocked

    def movement(self) -> bool:
        """Whether tests move."""
        test = self._control.hosted.shown.get("test") if self._control.hosted is not None else None
        return not isinstance(test, dict) or test.get("movement") is not False

    def order_test(self, what: str, **facts: Fact) -> None:
        """To the test system."""
        if self._control.hosted is not None:
            self._control.hosted.order(what, **facts)

    def tested(self) -> Sequence[tuple[int, str, int, bool]]:
        """Processes of the test: run, program, line, whether it is held."""
        hosted = self._control.hosted
        test = hosted.shown.get("test") if hosted is not None else None
        runs = {each.get("run") for each in test["tested"]} if isinstance(test, dict) else set()
        rows = hosted.rows if hosted is not None else []
        return [
            (int(str(row["run"])), str(row["program"]), int(str(row["line"])), row["state"] == "held")
            for row in rows
            if row["run"] in runs and not row["branch"]
        ]

    def start(self, name: str) -> object:
        return self._control.processes.start(name)
