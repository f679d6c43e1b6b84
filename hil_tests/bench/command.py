"""Benchmarks: cycle, 3964r, emulator, drives, planner, motion, lanes, modbus, route, web, program, robotstar, val3, conformance, or all.

all rewrites docs/benchmarks.md.
"""

import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import subprocess
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/benchmarks.md"
REFERENCES = ("cycle_ref", "modbus_load", "servo_ref")  # in build/
Figure = dict[str, object]
EXAMPLES = """examples:
  axisgate bench cycle --json                   the cycle against its twin in C, 6 blocks of 10 s each
  axisgate bench cycle --blocks 1 --seconds 2   a short look
  axisgate bench all                            everything; rewrites docs/benchmarks.md
"""


def cycle(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.cycle_bench import figures

    return figures(arguments.blocks, arguments.seconds or 10.0)


def p3964r(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench import p3964r_line, p3964r_pure

    return [p3964r_line.wire_ratio(), p3964r_line.blocks_per_s(), p3964r_pure.decode_mbps(), p3964r_pure.sim_telegrams_per_s()]


def drives(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.drives_bench import BLOCK_S, figures

    return figures(arguments.blocks, arguments.seconds or BLOCK_S)


def planner(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.planner_load import figures

    return figures(arguments.blocks, arguments.seconds or 10.0)


def emulator(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.emulator_bench import figures

    return figures()


def motion(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.motion_bench import run

    return [dict(figure) for figure in run()]


def lanes(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench import lanes_cell
    from hil_tests.bench.drives_bench import BLOCK_S
    from hil_tests.bench.lanes_bench import run

    pure: list[Figure] = [dict(figure) for figure in run()]
    return [*pure, *lanes_cell.figures(arguments.blocks, arguments.seconds or BLOCK_S)]


def route(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.route_bench import BLOCKS, ROUNDS, figures

    return figures(min(arguments.blocks, BLOCKS), ROUNDS if arguments.seconds is None else max(4, round(ROUNDS * arguments.seconds / 10.0)))


def modbus(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.modbus_bench import figures

    return figures()


def web(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.web_bench import SCOPE_S, figures

    return figures(arguments.seconds or SCOPE_S)


def program(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.program_bench import run

    return [dict(figure) for figure in run(short=arguments.seconds is not None)]


def robotstar(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.robotstar_bench import run

    return [dict(figure) for figure in run()]


def val3(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.val3_bench import run
    from hil_tests.bench.val3_cell_figures import SYNC_S

    return [dict(figure) for figure in run(arguments.seconds or SYNC_S)]


def conformance(arguments: argparse.Namespace) -> list[Figure]:
    from hil_tests.bench.conformance_bench import run

    return [dict(figure) for figure in run()]


BENCHES: dict[str, Callable[[argparse.Namespace], list[Figure]]] = {
    "cycle": cycle,
    "3964r": p3964r,
    "emulator": emulator,
    "drives": drives,
    "planner": planner,
    "motion": motion,
    "lanes": lanes,
    "route": route,
    "modbus": modbus,
    "web": web,
    "program": program,
    "robotstar": robotstar,
    "val3": val3,
    "conformance": conformance,
}


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bench", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", choices=[*BENCHES, "all"])
    parser.add_argument("--json", action="store_true", help="list of {figure, value, unit, reference, reference_value, ratio, goal, met}")
    parser.add_argument("--blocks", type=int, default=6, help="of each side in bench cycle, planner, drives and lanes (default 6)")
    parser.add_argument(
        "--seconds",
        type=float,
        help="of each block in bench cycle and planner (default 10), drives (5, at half the period) and lanes (5); of the scope in "
        "bench web (600); of the synchronous task in bench val3 (60); bench program: any makes it short",
    )
    arguments = parser.parse_args(argv)
    missing = [name for name in REFERENCES if not (ROOT / "build" / name).exists()]
    if missing:
        print(f"axisgate bench: {', '.join(missing)} not built; run: make references", file=sys.stderr)
        return 3
    found, broken = measured(list(BENCHES) if arguments.name == "all" else [arguments.name], arguments)
    if arguments.json:
        print(json.dumps(found, indent=1))
    if broken:
        print(f"axisgate bench: not measured: {', '.join(broken)} (the cause is above)", file=sys.stderr)
        return 3
    if arguments.name == "all":
        PAGE.write_text(page(found))
    return 0 if all(figure["met"] for figure in found) else 1


def measured(names: Sequence[str], arguments: argparse.Namespace) -> tuple[list[Figure], list[str]]:
    """Figures of these benches in this order and the names of those that failed twice.

    One failure must not lose the hour of the others: among several, a bench that fails is repeated once, after all of them.
    """
    found = dict[str, list[Figure]]()
    for name in names:
        attempt(name, arguments, found)
    again = [name for name in names if name not in found] if len(names) > 1 else []
    for name in again:
        print(f"axisgate bench: {name} failed (the cause is above) and is repeated", file=sys.stderr, flush=True)
        attempt(name, arguments, found)
    return [figure for name in names for figure in found.get(name, [])], [name for name in names if name not in found]


def attempt(name: str, arguments: argparse.Namespace, found: dict[str, list[Figure]]) -> None:
    """Run this bench and enter its figures; print the traceback of one that fails."""
    try:
        found[name] = [known(figure) for figure in BENCHES[name](arguments)]
    except Exception:
        traceback.print_exc()
        return
    if not arguments.json:
        print("\n".join(map(sentence, found[name])), flush=True)


def known(figure: Mapping[str, object]) -> Figure:
    """A value that was not taken, NaN, is None: JSON knows no NaN, and the page leaves it out.  So is the ratio of a figure without one."""
    taken = {name: None if isinstance(value, float) and math.isnan(value) else value for name, value in figure.items()}
    return {**taken, "ratio": taken.get("ratio")}


def sentence(figure: Figure) -> str:
    """One line of the table a person reads."""
    met = "met " if figure["met"] else "MISS"
    beside = ": ".join(text(figure.get(name)) for name in ("reference", "reference_value") if text(figure.get(name)))
    return f"{met}  {figure['figure']}: {text(figure['value'])} {figure['unit']}  (goal {figure['goal']}{beside and '; ' + beside})"


def text(value: object) -> str:
    return "" if value is None else str(value)


def page(found: list[Figure]) -> str:
    """docs/benchmarks.md as a whole: this run and nothing of an earlier one."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    head = [
        "# Benchmarks",
        "",
        "Written by `make bench`; measured at the bus or line by a third process, in blocks that alternate with the reference under",
        "the same load.",
        "The machine is shared with other work: compare ratios within one run, never single absolute times with another machine's.",
        "",
        f"Measured {datetime.date.today().isoformat()} on {os.cpu_count()} cores of {machine()}, Linux {platform.release()}, "
        f"Python {platform.python_version()}, commit {commit or 'unknown'}.",
        "",
        "| figure | value | unit | reference | its value | ratio | goal | met |",
        "|---|---|---|---|---|---|---|---|",
    ]
    keys = ("figure", "value", "unit", "reference", "reference_value", "ratio", "goal")
    rows = ["| " + " | ".join(text(figure.get(key)) for key in keys) + f" | {'yes' if figure['met'] else '**no**'} |" for figure in found]
    return "\n".join([*head, *rows, ""])


def machine() -> str:
    """Return the processor's name as the kernel reports it."""
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()
