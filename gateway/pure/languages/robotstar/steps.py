"""Makes the functions of a program's steps."""

from collections.abc import Callable, Mapping

from gateway.pure.languages.robotstar import control_steps, data_steps, motion_steps
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.machine import Machine, Op
from gateway.pure.languages.robotstar.pallet import pallet
from gateway.pure.languages.robotstar.program import DEFINITIONS, HEADS, Program, Step
from gateway.pure.languages.robotstar.trafo import trafo

Maker = Callable[[Machine, Step, int], Op]
MAKERS: Mapping[str, Maker] = {
    "COPY": data_steps.copy_step,
    "COPY_OFFSETS": data_steps.copy_offsets,
    **dict.fromkeys(("ADD", "SUB", "MUL", "DIV", "MODULO"), data_steps.math_step),
    "NEG": data_steps.negate,
    **dict.fromkeys(("AND", "OR", "EXCL_OR", "SHIFT_L", "SHIFT_R"), data_steps.logic_step),
    "INVERT": data_steps.invert,
    "VEC_ADD": data_steps.vector_step,
    "VEC_SUB": data_steps.vector_step,
    "VEC_VALUE": data_steps.vector_value,
    "WRITE_BIT": control_steps.write_bit,
    "WAIT": control_steps.wait,
    "CALL": control_steps.call,
    "ANA_OUTP": control_steps.analog_output,
    "ANA_INP": control_steps.analog_input,
    "TOOL": motion_steps.tool,
    "POSITION": motion_steps.position,
    "VAR_POS": motion_steps.position,
    "ACT_POS": motion_steps.actual_position,
    "MOVE_MODE": motion_steps.mode,
    "FLYBY": motion_steps.flyby,
    **dict.fromkeys(motion_steps.PARAMETERS, motion_steps.parameter),
    "RELATIVE": motion_steps.relative,
    "CALC_REL": motion_steps.calc_rel,
    "MOUSE_CALIBRATION": motion_steps.calibrate,
    "PALLET": pallet,
    "TRAFO_6D": trafo,
}
BRANCHES: Mapping[str, Callable[[Machine, Step, int, Program], Op]] = {
    "WAIT_BIT": control_steps.wait_bit,
    "TEST_BIT": control_steps.test_bit,
    "TEST": control_steps.test_value,
    "BRANCH": control_steps.branch,
}
NOT_IN_EXECUTER = frozenset(  # Test 5 (L1248-1258); WAIT is effective in all test modes (L658)
    ("WAIT_BIT", "POSITION", "VAR_POS", "CALC_REL", "OSCILLATION", "WELDING", *motion_steps.PARAMETERS, "MOVE_MODE", "FLYBY")
)


def build(machine: Machine, program: Program) -> list[Op]:
    """One function a step, in their order."""
    return [_guarded(machine, step, _made(machine, step, index + 1, program)) for index, step in enumerate(program.steps)]


def _made(machine: Machine, step: Step, following: int, program: Program) -> Op:
    if not step.valid or (not step.macro and (step.word in HEADS or step.word in DEFINITIONS or step.word in ("C", "LABEL"))):
        return lambda: following
    if step.macro:
        return control_steps.macro(machine, step, following)
    if step.word == "END":
        return machine.end
    if step.word == "STOP":
        return control_steps.stop(machine, following)
    if step.word == "PROGRAM":
        return control_steps.switch(machine, step)
    if step.word in BRANCHES:
        return BRANCHES[step.word](machine, step, following, program)
    if step.word in MAKERS:
        return MAKERS[step.word](machine, step, following)
    return _not_built(step.word)


def _not_built(word: str) -> Op:
    def op() -> int:
        raise StepFault(f"{word} is not executed by this control")

    return op


def _guarded(machine: Machine, step: Step, op: Op) -> Op:
    """A step that the executer refuses."""
    if step.word not in NOT_IN_EXECUTER or step.macro or not step.valid:
        return op

    def guarded() -> int:
        if machine.executer:
            raise StepFault(f"{step.text.split()[0]} is not executable in Test 5", 0, "operating")
        return op()

    return guarded
