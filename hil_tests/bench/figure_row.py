"""A row of the motion figures: figure, value, unit, goal, met, reference, reference_value."""

import math
import time

Figure = dict[str, str | float | bool]
RECORDED = "motion.md, recorded"
EMPTY_LOOP = "turns of an empty Python loop a second"
TURNS = 10_000_000


def loop_turns() -> float:
    """Speed of this machine now, the reference for figures of plain computing."""
    began = time.perf_counter()
    for _ in range(TURNS):
        pass
    return TURNS / (time.perf_counter() - began)


def row(
    figure: str, value: float, unit: str, goal: float, reference: str = "", anchor: float = math.nan, *, at_least: bool = False
) -> Figure:
    met = value >= goal if at_least else value <= goal
    return {
        "figure": figure,
        "value": float(f"{value:.6g}"),
        "unit": unit,
        "goal": goal,
        "met": bool(met),
        "reference": reference,
        "reference_value": float(f"{anchor:.6g}"),
    }
