"""SYVARINI: sets system variables when the control is switched on.  Source: robotstar 3.6, L1282, L2045, D-13.  Pure."""

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.machine import Halted, Machine
from gateway.pure.languages.robotstar.path import PathState

NAME = "SYVARINI"
MOST = 10_000  # steps: it sets values and ends


def initialise(machine: Machine) -> tuple[str, int, str]:
    """Runs the program of the memory to its end: what it stops with, and where; "" where nothing is wrong.  No program is selected then."""
    program = machine.memory.find(NAME, kinds=("MPR", "SPR", "MAC"))
    wrong, step = "", 1
    if program is not None and program.refused:
        return f"program {program.name} has faults: {program.refused[0][1]}", 1, program.key
    if program is not None:
        repeats, machine.repeats = machine.repeats, False
        machine.select(program)
        try:
            if machine.run(MOST) == 0 or machine.request is not None or machine.idle:
                wrong = f"{NAME} only assigns values to variables: it neither waits nor moves the robot"
        except Halted:
            pass
        except StepFault as fault:
            ended = machine.frame is not None and machine.frame.at == len(program.steps) - 1  # of a sub-program that was not called
            wrong = "" if ended else fault.text
        step = machine.frame.at + 1 if machine.frame is not None else 1
        machine.repeats = repeats
    machine.stack, machine.frame, machine.request, machine.idle = [], None, None, False
    machine.path = PathState(machine.path.defaults)
    return wrong, step, program.key if program is not None else ""
