"""Drives at 2 ms: six axes on one bus and twelve on two, against the cycle's twin in C; what the cycle costs; 24 emulated drives.

Judged as bench cycle: by the brokers' logs and their stamps, in blocks that alternate with the reference under the same Modbus load.
"""

import pathlib
import re
import statistics
import tempfile

from gateway.files.find import find_config
from hil_tests.bench.cycle_bench import Side, alternate, running
from hil_tests.bench.emulated_drives import emulated_24

Figure = dict[str, object]
P5_MS = 2
CPU_GOAL = 12.0  # % of a core
BLOCK_S = 5.0  # 6 blocks of 2,250 judged cycles: at 2 ms as many in half the time as bench cycle has at 4 ms


def figures(blocks: int = 6, seconds: float = BLOCK_S) -> list[Figure]:
    """All rows of `axisgate bench drives`; 4 minutes with these blocks."""
    return [*one_bus(blocks, seconds), *two_buses(blocks, seconds), *emulated_24(seconds)]


def one_bus(blocks: int, seconds: float) -> list[Figure]:
    """drives.skipped_2ms, incomplete_2ms, cycle_cpu: six axes."""
    ours, theirs = Side(), Side()
    with (
        tempfile.TemporaryDirectory(prefix="axisgate-bench-") as folder,
        running(pathlib.Path(folder), "demo", P5_MS, "bench-drives") as bench,
    ):
        repeated = alternate(bench, ours, theirs, blocks, seconds)
        cpu, moves = statistics.median(bench.cpu) * 100.0 if bench.cpu else float("nan"), bench.moves
    met, beside = cpu <= CPU_GOAL, f"the goal; {moves} moves of all axes meanwhile"
    row = {"figure": "drives.cycle_cpu", "value": round(cpu, 2), "unit": "% of a core", "reference": beside,
           "reference_value": CPU_GOAL, "ratio": round(cpu / CPU_GOAL, 3), "goal": f"<= {CPU_GOAL:g}", "met": met}  # fmt: skip
    return [*compared(ours, theirs, repeated, moves, "drives.{}_2ms"), row]


def two_buses(blocks: int, seconds: float) -> list[Figure]:
    """drives.skipped_2ms_12, incomplete_2ms_12: twelve axes, both buses judged."""
    ours, theirs = Side(), Side()
    with tempfile.TemporaryDirectory(prefix="axisgate-bench-") as folder:
        cell = pathlib.Path(folder) / "twelve.toml"
        cell.write_text(twelve_axes(find_config("demo", "cells").read_text()))
        with running(pathlib.Path(folder), str(cell), P5_MS, "bench-twelve", ("drives", "drives2")) as bench:
            repeated = alternate(bench, ours, theirs, blocks, seconds)
            moves = bench.moves
    return compared(ours, theirs, repeated, moves, "drives.{}_2ms_12")


def compared(ours: Side, theirs: Side, repeated: int, moves: int, name_of: str) -> list[Figure]:
    """Skipped and incomplete cycles with the goals of bench cycle, named by `name_of`; without a single move they are not met."""
    rows: list[Figure] = []
    reference = f"the same cycle in C, {len(theirs.verdicts)} verdicts ({repeated} blocks repeated); ours made {moves} moves"
    for name in ("skipped", "incomplete"):
        mine, other = ours.per_15000(name), theirs.per_15000(name)
        rows.append(
            {"figure": name_of.format(name), "value": round(mine, 3), "unit": "per 15,000 cycles", "reference": reference,
             "reference_value": round(other, 3), "ratio": round(mine / other, 3) if other else None,
             "goal": "<= C + 1 per 15,000 cycles", "met": moves > 0 and mine <= other + 1.0}
        )  # fmt: skip
    return rows


def twelve_axes(text: str) -> str:
    """The demo's cell with its bus, axes and plant once more: A7 .. A12 on bus drives2."""
    buses = tables(text, r"\[\[bus\]\]")
    axes = tables(text, r"\[\[axis\]\]")
    plant = tables(text, r"\[plant\.axis\.A\d\]")
    second = "\n".join([*buses, *axes]).replace('"drives"', '"drives2"')
    second = re.sub(r'"A(\d)"', lambda found: f'"A{int(found[1]) + 6}"', second)
    moved = re.sub(r"\[plant\.axis\.A(\d)\]", lambda found: f"[plant.axis.A{int(found[1]) + 6}]", "\n".join(plant))
    return text + "\n" + second + "\n" + moved


def tables(text: str, head: str) -> list[str]:
    """Every table that begins with this head, up to the next one."""
    return [found[0] for found in re.finditer(rf"^{head}.*?(?=^\[|\Z)", text, re.MULTILINE | re.DOTALL)]
