"""Three points that make no circle: at the end of an arc as it is executed, and in a listing where all three are given by numbers.
Source: robotstar 3.1 (L308-338).  The manual prints neither number nor text; the limits are the planner's.
"""

from collections.abc import Iterator, Sequence

from gateway.pure.languages.robotstar.operands import Equate, Number
from gateway.pure.languages.robotstar.path import CARTESIAN, CIRCLES, circle_open, no_circle
from gateway.pure.languages.robotstar.program import Program, Step

Point = Sequence[float]
UNKNOWN: Point = ()
LEAVES = ("CALL", "LABEL", "PROGRAM")  # what follows may come from elsewhere, in any mode
DISPLACED = ("RELATIVE", "PALLET")


def wrong_circles(program: Program) -> Iterator[tuple[Step, str]]:
    """Steps at which an arc cannot be, and why.  Only what the listing alone shows: no label, call or displacement in between."""
    mode, points = "", [UNKNOWN]  # of the arc that is begun, its start first
    skips = False  # the next position supplies the vector of CALC_REL and is not approached
    for step in program.steps:
        if not step.valid:
            continue
        if step.macro or step.word in LEAVES:
            mode, points, skips = "", [UNKNOWN], False
        elif step.word in DISPLACED:
            points = [UNKNOWN] * len(points)
        elif step.word == "CALC_REL":
            skips = True
        elif step.word == "MOVE_MODE":
            before, mode = mode, _equate(step)
            if mode != before and before in CIRCLES and len(points) == 2:
                yield step, circle_open(mode)
            points = points[-1:]
        elif step.word in ("POSITION", "VAR_POS"):
            if skips:
                skips = False
                continue
            points.append(_point(step))
            if mode not in CIRCLES:
                points = points[-1:]
            elif len(points) == 3:
                if all(points) and (wrong := no_circle(*points)):
                    yield step, wrong
                points = points[-1:]


def _equate(step: Step) -> str:
    given = step.slots.get("mode")
    return given.name if isinstance(given, Equate) else ""


def _point(step: Step) -> Point:
    """X Y Z by numbers, in the basic system."""
    given = [step.slots.get(name) for name in CARTESIAN[:3]]
    values = [operand.value for operand in given if isinstance(operand, Number)]
    return UNKNOWN if len(values) < 3 or "FRAME" in step.slots else [float(value) for value in values]
