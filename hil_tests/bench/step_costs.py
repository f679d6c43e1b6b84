"""What a period costs, with what a cell of this machine looks ahead with (C, where it was built) and with its twin in Python, in turn."""

import gc
import statistics
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from gateway.cycle.native.quick import NativeParts
from hil_tests.bench.figure_row import Figure, row
from motion.timing.foresight import Foresight

MEDIAN, MOST = 60.0, 150.0  # us


@contextmanager
def uncollected() -> Iterator[None]:
    """No garbage is collected meanwhile, as in the cycle's process."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def percentile(values: list[int], share: float) -> float:
    """Microseconds."""
    return sorted(values)[min(int(len(values) * share), len(values) - 1)] / 1000


def median_of(repeats: int, run: Callable[[], list[int]]) -> list[int]:
    """The median of each of the same periods, run so often: what interrupts one of them does not count, what each of them costs does."""
    return [round(statistics.median(same)) for same in zip(*(run() for _ in range(repeats)), strict=True)]


def cost_rows(
    figure: str, reference: tuple[str, float, float], rounds: int, repeats: int, run: Callable[[int, type[Foresight]], list[int]]
) -> list[Figure]:
    """Rows `figure`_p50 and _p99, and the same in Python.

    reference: what it is, its median and 99th percentile in us; run: ns of each period of a round, the same for the same round.
    """
    kinds = {"": NativeParts().foresight, "_python": Foresight}
    costs: dict[str, list[int]] = {name: [] for name in kinds}
    with uncollected():
        for n in range(rounds):
            for name, kind in kinds.items():
                costs[name] += median_of(repeats, partial(run, n, kind))
    unit, (words, median, most) = f"us of processor time, median of {repeats} same runs", reference
    rows = []
    for name, all_costs in costs.items():
        rows += [
            row(f"{figure}_p50{name}", percentile(all_costs, 0.5), unit, MEDIAN, words, median),
            row(f"{figure}_p99{name}", percentile(all_costs, 0.99), unit, MOST, words, most),
        ]
    return rows
