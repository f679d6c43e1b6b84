"""Compare the machine with its old positions: walks the [[check_position]] list and prints old, new and the difference."""

import argparse
import json

from gateway.assembly.run import slug_of
from gateway.pure.cell.cell import Cell, CheckPosition
from gateway.pure.image.records.cell import AxisFlag
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError, mask_of, running, simulated
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.drives.first_enable import percent
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate positions cell.toml                  asks you to bring the axes to each mark by hand, then reads them
  axisgate positions cell.toml --go             drives to each position slowly (first_enable speed) and reads its position
  axisgate positions s5-rk512 --sim --go --json without hardware
"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate positions", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", help="cell file, or the name of a shipped one")
    parser.add_argument("--go", action="store_true", help="drive there instead of asking")
    parser.add_argument("--name", help="name of the run, if it differs from the file")
    parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    if not cell.check_position:
        complain("positions", f"{arguments.cell} has no [[check_position]]: name = ..., at = {{ X = 12.5 }}, tolerance = 0.2")
        return USAGE
    try:
        if arguments.sim:
            with simulated(arguments.cell) as (client, _):
                client.wait_ready()
                rows = walk(client, cell, go=arguments.go)
        else:
            with running(arguments.name or slug_of(cell)) as client:
                rows = walk(client, cell, go=arguments.go)
    except (ToolError, EOFError) as error:
        complain("positions", error)
        return ENVIRONMENT
    print(json.dumps(rows, indent=1) if arguments.json else table(rows))
    return DONE if all(row["good"] for row in rows) else FINDING


def walk(client: ToolClient, cell: Cell, *, go: bool) -> list[Row]:
    """One row for each position and axis."""
    if go:
        client.take_over()
        everything = mask_of(cell, [axis.name for axis in cell.axis])
        client.command("enable", everything)
        referenced = all(int(str(row["flags"])) & AxisFlag.REFERENCED for row in client.axes())
        if not referenced:
            client.command("reference", everything, timeout_s=max(axis.home.timeout_s for axis in cell.axis) + 10.0)
    rows: list[Row] = []
    try:
        for position in cell.check_position:
            rows += _visit(client, cell, position, go=go)
    finally:
        if go:
            client.command("disable", everything)
            client.command("release_control")
    return rows


def _visit(client: ToolClient, cell: Cell, position: CheckPosition, *, go: bool) -> list[Row]:
    places = dict(position.at) | dict(zip((axis.name for axis in cell.axis), position.joints, strict=False))
    if go:
        targets = [0.0] * len(cell.axis)
        for n, axis in enumerate(cell.axis):
            targets[n] = places.get(axis.name, 0.0)
        speed = min(percent(axis.first_enable.speed) for axis in cell.axis)
        client.command("ptp_absolute", mask_of(cell, list(places)), velocity=max(speed, 0.05), targets=targets, timeout_s=600.0)
    else:
        input(f"{position.name}: bring {', '.join(places)} to the mark, then Enter ")
    found = {str(row["name"]): row for row in client.axes()}
    rows: list[Row] = []
    for name, old in places.items():
        new = float(str(found[name]["actual"]))
        row = {"position": position.name, "axis": name, "unit": found[name]["unit"], "old": old, "new": round(new, 4)}
        rows.append(
            {**row, "difference": round(new - old, 4), "tolerance": position.tolerance, "good": abs(new - old) <= position.tolerance}
        )
    return rows


def table(rows: list[Row]) -> str:
    """For a person and a folder."""
    head = f"{'position':<24} {'axis':<6} {'old':>10} {'new':>10} {'difference':>11} {'tolerance':>10}"
    lines = [
        f"{row['position']!s:<24} {row['axis']!s:<6} {row['old']:>10.3f} {row['new']:>10.3f} {row['difference']:>+11.3f} "
        f"{row['tolerance']:>10.3f}  {'' if row['good'] else 'BEYOND'}".rstrip()
        for row in rows
    ]
    worst = sum(not row["good"] for row in rows)
    return "\n".join([head, *lines, f"{len(rows)} values, {worst} beyond their tolerance"])
