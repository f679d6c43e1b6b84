"""PHG 2000 variables of a running control by name: phg.33026.85, coded phg.33282.2.3 (kinematic, axis), phg.33793.  AX-486, AX-496.

What this control does not have (boards, object coordinates, files without a memory) is refused, never shown as a zero.
"""

from gateway.pure.controllers.rho3.functions.system_variables import FILES, FREE, SystemVariables, VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import TEXT_LISTS, variable_of
from gateway.pure.controllers.rho3.pendant.variables import AxisView, KinematicView, Machine, Message, SetBits, SetFactor, Value, Variables
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.control_state import ControlState
from gateway.pure.controllers.rho3.signals.errors import RHO3
from gateway.pure.image.records.cell import MOST_AXES, AxisFlag, AxisState

WARNINGS = 5  # group of error codes (rho3 3.3)
AREA = 128  # bytes of the PIC's areas
USER_OUTPUTS = 128
NO_AXES = [AxisState()] * MOST_AXES  # until the cycle has spoken


class PhgValues:
    """Reads and writes one control; the selected process stays selected."""

    def __init__(self, control: ControlState) -> None:
        self._control = control
        self._listed = SystemVariables(control.processes, memory=control.setup.memory, language=control.setup.functions.language)
        self._variables = Variables(Machine(), self._listed)

    def read(self, name: str) -> Value:
        """KeyError, VariableError."""
        variable, index = variable_of(name)
        if not self._control.setup.memory and (FILES <= variable.code <= FREE or variable.code in TEXT_LISTS):
            raise VariableError(f"{name} {variable.name}: this control has none; [controller] memory names its folder")
        self._variables.machine = self._machine()
        self._listed.files = self._control.memory.files
        self._listed.memory = self._control.memory.card or self._control.setup.memory
        return self._variables.read(variable.code, index)

    def number(self, name: str) -> float:
        """For registers and data blocks; ValueError: it is a text."""
        value = self.read(name)
        if isinstance(value, str):
            raise ValueError(f"{name}: a text has no number")
        return float(value)

    def write(self, name: str, value: Value) -> None:
        """KeyError, VariableError; nothing is done then."""
        variable, index = variable_of(name)
        self._variables.machine = self._machine()
        order = self._variables.write(variable.code, value, index)
        match order:
            case SetFactor(kinematic, which, share):
                self._control.set_factor(which, share, kinematic)
            case SetBits(first, bits):
                self._outputs(name, first, bits)

    def _outputs(self, name: str, first: int, bits: tuple[bool, ...]) -> None:
        """Write RC outputs: those without another writer belong to the user."""
        base = self._control.setup.numbers.first_output
        if not base <= first or first + len(bits) > base + USER_OUTPUTS:
            raise VariableError(f"{name}: the control writes it itself; user outputs are bits {base} to {base + USER_OUTPUTS - 1}")
        for place, value in enumerate(bits, first - base + 1):
            self._control.user.write(place, value)

    def _machine(self) -> Machine:
        control = self._control
        records = [each for each in control.errors.records if each.source == RHO3]
        language = control.setup.functions.language
        entries = [(each.code, Message(each.code, 0, f"{code_text(each.code, language)} {each.where}".strip())) for each in records]
        return Machine(
            pic_inputs=bytes(control.image.outputs)[:AREA].ljust(AREA, b"\0"),
            rci=bytes(control.image.inputs)[:AREA].ljust(AREA, b"\0"),
            flags=bytes(control.image.flags)[:AREA].ljust(AREA, b"\0"),
            kinematics=self._kinematics(),
            factors=control.factor_table.global_factors(),
            text_lists=control.memory.lists,
            clock_ms=control.now // 1_000_000,
            warnings=tuple(message for code, message in entries if code >> 8 == WARNINGS),
            errors=tuple(message for code, message in entries if code >> 8 != WARNINGS),
        )

    def _kinematics(self) -> tuple[KinematicView, ...]:
        """All axes of a cell are those of its first kinematic."""
        control, setup = self._control, self._control.setup
        axes = tuple(
            AxisView(name, axis.set * factor, axis.actual * factor, axis.lag * factor, bool(axis.flags & AxisFlag.IN_POSITION), most, least)
            for name, (_, factor), (least, most), axis in zip(
                setup.axes, setup.units, setup.limits, [*control.cell.axes, *NO_AXES], strict=False
            )
        )
        count = setup.installation.kinematics
        return tuple(
            KinematicView(axes if number == 1 else (), factors=control.factor_table.kinematic_factors(number))
            for number in range(1, count + 1)
        )
