"""The page `axisgate demo` leaves: what its witnesses found, and the paths of a SCARA and a six-axis arm as the motion core plans them."""

import html
import pathlib
from collections.abc import Sequence

from gateway.files.find import find_config, read_text
from gateway.files.robots import load_robot
from gateway.pure.reports.svg import draw
from gateway.tools.motion.plot import STYLE, way_charts
from hil_tests.lab.judges.judge import Verdict
from motion.planner.robot import machine_of
from motion.planner.trace import route_of
from motion.program.text.reader import read

SHOWN = (("SCARA: pick and place", "scara-pick-and-place", "scara"), ("Six-axis arm: U cycle and circle", "arm-u-cycle", "arm6"))


def write(path: pathlib.Path, verdicts: Sequence[Verdict]) -> None:
    """One self-contained HTML document."""
    rows = "".join(
        f"<tr><td>{html.escape(v.name)}</td><td>{v.value:.4g}</td><td>{html.escape(v.limit)}</td>"
        f'<td class="{"" if v.ok else "over"}">{"holds" if v.ok else "FAILS"}</td></tr>'
        for v in verdicts
    )
    body = [
        "<h1>axisgate demo</h1>",
        "<p>Two PLCs moved six emulated drives; emulator, bus log and line record judged it. Nothing here was measured on metal.</p>",
        f"<h2>Verdicts</h2><table><tr><th>what</th><th>found</th><th>limit</th><th></th></tr>{rows}</table>",
        "<h2>Robots</h2><p>The same motion core plans for robots of any kind; these are the paths of two shipped programs.</p>",
        *(part for title, program, cell in SHOWN for part in _robot(title, program, cell)),
    ]
    path.write_text(
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>axisgate demo</title><style>{STYLE}</style></head>\n<body>\n'
        + "\n".join(body)
        + "\n</body></html>\n"
    )


def _robot(title: str, name: str, cell: str) -> list[str]:
    program = read(read_text(find_config(name, "programs")))
    machine = machine_of(load_robot(program.robot))
    charts = way_charts(machine, route_of(program, machine))
    words = f"robot {program.robot}, {len(program.blocks)} blocks; play it: <code>axisgate motion run {cell} 1 --sim</code>"
    return [f"<h2>{html.escape(title)}</h2>", f"<p>{words}</p>", *(draw(chart, 860, 420) for chart in charts)]
