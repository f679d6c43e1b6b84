"""The page `axisgate motion plot` writes: path, speed, acceleration, jerk, axis loads and corner deviations of one program."""

import html
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gateway.pure.reports.svg import Chart, Line, draw
from motion.geometry.units import from_si
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.planner.trace import Findings, Trace, tool_places
from motion.program.blocks import Program
from motion.program.team import TeamProgram

STYLE = """
:root { color-scheme: light dark; --ink: #222; --field: #fbfbf9; --grid: #dcdcd6; --bound: #b00020; --page: #ffffff; }
@media (prefers-color-scheme: dark) { :root { --ink: #ddd; --field: #1d1f21; --grid: #3a3d40; --bound: #ff6b6b; --page: #141516; } }
body { font: 15px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--page); margin: 24px auto;
  max-width: 900px; padding: 0 12px; }
h1 { font-size: 22px; margin: 0 0 4px; } h2 { font-size: 17px; margin: 22px 0 6px; }
svg { max-width: 100%; height: auto; display: block; margin: 10px 0; }
svg text { font: 11px system-ui, sans-serif; fill: var(--ink); } svg .title { font-size: 13px; font-weight: 600; }
.field { fill: var(--field); stroke: var(--grid); } .grid { stroke: var(--grid); stroke-width: 1; }
.bound { stroke: var(--bound); stroke-width: 1.2; stroke-dasharray: 5 4; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; } th, td { padding: 3px 12px 3px 0; text-align: right; }
th { border-bottom: 1px solid var(--grid); } .over { color: var(--bound); font-weight: 600; }
"""
Array = NDArray[np.float64]
WAY_POINTS = 80  # of each stretch
ORDERS = ((1, "speed"), (2, "acceleration"), (3, "jerk"))


def page(program: Program, machine: Machine, trace: Trace) -> str:
    """One self-contained HTML document."""
    title = html.escape(program.name or "program")
    return _document(
        title, [_head(title, f"robot {program.robot}", len(program.blocks), trace), *_alterable(program), *_body(machine, trace)]
    )


def team_page(program: TeamProgram, team: Team, traces: Sequence[Trace]) -> str:
    """The same for several kinematics, one below the other over the same time."""
    title = html.escape(program.name or "program")
    body = [_head(title, f"{len(program.kinematics)} kinematics on one clock", len(program.blocks), traces[0])]
    for each, machine, trace in zip(program.kinematics, team.machines, traces, strict=True):
        body += [f"<h1>{html.escape(each.name)}: {html.escape(each.robot)}</h1>", *_body(machine, trace)]
    return _document(title, body)


def _head(title: str, who: str, blocks: int, trace: Trace) -> str:
    return (
        f"<h1>{title}</h1>\n<p>{html.escape(who)}, {blocks} blocks, {trace.t[-1]:.3f} s at 100 %, set values on a grid of "
        f"{trace.period * 1e3:g} ms.</p>"
    )


def _body(machine: Machine, trace: Trace) -> list[str]:
    """Charts of one robot."""
    return [
        "<h2>Path of the tool</h2>",
        *(draw(chart, 860, 420) for chart in _planes(trace.tool, np.searchsorted(trace.t, [t for _, t in trace.ends]).tolist())),
        "<h2>Along time</h2>",
        *(draw(chart) for chart in _over_time(machine, trace)),
        "<h2>Largest loads</h2>",
        _loads(machine, trace),
        "<h2>Corners</h2>",
        _corners(trace),
    ]


def _document(title: str, body: Sequence[str]) -> str:
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style></head>\n<body>\n'
        + "\n".join(body)
        + "\n</body></html>\n"
    )


def _alterable(program: Program) -> list[str]:
    """Which blocks a correction may move: it is not known here."""
    found = [str(number) for number, block in enumerate(program.blocks, 1) if block.alteration is not None]
    return [f"<p>Alterable, drawn without a correction: block {', '.join(found)}.</p>"] if found else []


def way_charts(machine: Machine, findings: Findings) -> list[Chart]:
    """The path of a program alone, without times: the result of `route_of`, from above and from the side."""
    tools, ends = [], []
    for stretch in findings.stretches:
        tools.append(tool_places(stretch, machine, WAY_POINTS))
        if stretch.stop:
            ends.append(sum(len(part) for part in tools) - 1)
    return _planes(np.concatenate(tools), ends) if tools else []


def _planes(tool: Array, marks: Sequence[int]) -> list[Chart]:
    """tool: (n, 3) m; marks: where it rests.  The plane with the most in it first."""
    x, y, z = (tool[:, k] * 1e3 for k in range(3))
    planes = [("seen from above", "x mm", "y mm", x, y)]
    side = ("x mm", x) if np.ptp(x) >= np.ptp(y) else ("y mm", y)
    if np.ptp(z) > 1e-6:
        planes.append(("seen from the side", side[0], "z mm", side[1], z))
    charts = []
    for title, x_label, y_label, a, b in planes:
        stops = [0, *(min(int(k), len(a) - 1) for k in marks)]
        lines = [Line("tool", a.tolist(), b.tolist()), Line("rest", [float(a[k]) for k in stops], [float(b[k]) for k in stops], dots=True)]
        charts.append(Chart(title, x_label, y_label, lines, equal=True))
    return charts


def _over_time(machine: Machine, trace: Trace) -> list[Chart]:
    t = trace.t.tolist()
    speed = trace.tool_speed() * 1e3
    pull = np.linalg.norm(trace.rate(trace.tool, 2), axis=1)
    jolt = np.linalg.norm(trace.rate(trace.tool, 3), axis=1)
    charts = [
        Chart("speed of the tool", "s", "mm/s", [Line("tool", t, speed.tolist())]),
        Chart("acceleration of the tool", "s", "m/s2", [Line("tool", t, pull.tolist())]),
        Chart("jerk of the tool", "s", "m/s3", [Line("tool", t, jolt.tolist())]),
    ]
    for way in trace.belts:
        value = Line("counter", way.t.tolist(), [from_si(float(v), way.unit) for v in way.value])
        charts.append(Chart(f"belt {way.name} while blocks lie on it", "s", way.unit, [value]))
    units = [axis.unit for axis in machine.limits]
    for unit in dict.fromkeys(units):
        rows = [n for n, each in enumerate(units) if each == unit]
        places = [Line(machine.name(n), t, [from_si(float(v), unit) for v in trace.q[:, n]], colour=n) for n in rows]
        charts.append(Chart(f"positions of the axes in {unit}", "s", unit, places))
    for order, name in ORDERS:
        loads = trace.loads(machine, order) * 100
        lines = [Line(machine.name(n), t, loads[:, n].tolist()) for n in range(machine.axes)]
        charts.append(Chart(f"{name} of the axes, share of each limit", "s", "%", lines, bound=100.0))
    return charts


def _loads(machine: Machine, trace: Trace) -> str:
    rows = ["<table><tr><th>axis</th><th>speed %</th><th>acceleration %</th><th>jerk %</th></tr>"]
    tops = [np.max(trace.loads(machine, order), axis=0) * 100 for order, _ in ORDERS]
    for n in range(machine.axes):
        cells = "".join(
            f'<td class="{"over" if top[n] > bound else ""}">{top[n]:.1f}</td>' for top, bound in zip(tops, (100.01, 102, 105), strict=True)
        )
        rows.append(f"<tr><td>{html.escape(machine.name(n))}</td>{cells}</tr>")
    return "\n".join([*rows, "</table>"])


def _corners(trace: Trace) -> str:
    if not trace.corners:
        return "<p>No point is passed: the program stops at each.</p>"
    rows = ["<table><tr><th>block</th><th>line</th><th>missed by mm</th><th>left before mm</th><th>reached after mm</th></tr>"]
    for corner in trace.corners:
        rows.append(
            f"<tr><td>{corner.block}</td><td>{corner.line or ''}</td><td>{corner.missed * 1e3:.3f}</td><td>{corner.begins * 1e3:.3f}</td>"
            f"<td>{corner.ends * 1e3:.3f}</td></tr>"
        )
    return "\n".join([*rows, "</table>"])
