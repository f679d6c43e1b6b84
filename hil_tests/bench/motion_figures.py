"""Figures of paths, laws and the stepper (motion.md E), all in one list; `figures()` runs all of them.

Anchors are measured in the same run where they can be (toppra, ruckig, exact stops); the others are the measured values of motion.md
C.5 to C.7 and say so.
"""

from collections.abc import Callable

from gateway.tools.progress import steps
from hil_tests.bench import online_figures, path_figures
from hil_tests.bench.figure_row import Figure

ALL: tuple[Callable[[], Figure | list[Figure]], ...] = (
    path_figures.corner_dev,
    online_figures.curve_identity,
    path_figures.u_portal,
    path_figures.u_portal_wide,
    path_figures.u_6r,
    path_figures.contour,
    path_figures.topp_vs_toppra,
    path_figures.ptp_vs_ruckig,
    path_figures.ptp_passing,
    online_figures.override,
    online_figures.stop_time,
    path_figures.singularity,
    online_figures.step_costs,
    path_figures.plan_ms,
    online_figures.limits_kept,
)


def figures() -> list[Figure]:
    """All rows."""
    rows: list[Figure] = []
    for function in steps("motion, figures", ALL):
        result = function()
        rows += result if isinstance(result, list) else [result]
    return rows


if __name__ == "__main__":
    for figure in figures():
        verdict = "met" if figure["met"] else "MISSED"
        print(f"{figure['figure']:28} {figure['value']:>12} {figure['unit']:16} goal {figure['goal']:<8} {verdict}")
