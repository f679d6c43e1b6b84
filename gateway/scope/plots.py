"""Plots of a recording: one HTML page without scripts, or a PNG; cursors as lines with their values, or one channel over another."""

import html
import pathlib
from collections.abc import Sequence

import numpy as np

from gateway.pure.reports.svg import Chart, Line, draw
from gateway.scope.recording import Recording, RecordingError

STYLE = """
body{font:14px/1.45 system-ui,sans-serif;max-width:64em;margin:1.5em auto;padding:0 1em;color:#1b1b1b;background:#fff}
svg text{font:11px sans-serif;fill:#333}.field{fill:#fff;stroke:#888}.grid{stroke:#e3e3e3}.bound{stroke:#c03030;stroke-dasharray:5 3}
svg{max-width:100%;height:auto}table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.2em .6em;text-align:right}
"""


def at_cursors(recording: Recording, cursors: Sequence[float]) -> list[list[float]]:
    """A row for each cursor: time of the nearest record, then the channels' values; raises RecordingError outside the recording."""
    rows = []
    for cursor in cursors:
        if not len(recording.time) or not recording.time[0] <= cursor <= recording.time[-1]:
            span = f"{recording.time[0]:.3f} to {recording.time[-1]:.3f} s" if len(recording.time) else "it is empty"
            raise RecordingError(f"cursor {cursor:g} s is outside the recording: {span}")
        place = int(np.argmin(np.abs(recording.time - cursor)))
        rows.append([float(recording.time[place]), *map(float, recording.values[place])])
    return rows


def page(recording: Recording, cursors: Sequence[float] = (), xy: tuple[str, str] | None = None) -> str:
    """Channels of one unit share a chart; with `xy` there is one chart of the second over the first."""
    charts = [_xy_chart(recording, *xy)] if xy else _charts(recording)
    pictures = "\n".join(draw(chart) for chart in charts)
    head = f"{recording.cell}: {len(recording.time)} records, period {recording.period_s * 1e3:g} ms"
    trigger = f"trigger {recording.trigger}" if recording.trigger else "no trigger"
    lost = f", {recording.lost} records lost" if recording.lost else ", no record lost"
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>axisgate scope</title><style>{STYLE}</style>
<h1>{html.escape(recording.cell)}</h1><p>{html.escape(head)}, {html.escape(trigger)}, {html.escape(recording.started)}{lost}</p>
{pictures}
{_table(recording, cursors)}</html>
"""


def picture(recording: Recording, path: pathlib.Path, cursors: Sequence[float] = (), xy: tuple[str, str] | None = None) -> None:
    """A PNG of the same charts; raises RecordingError where matplotlib is not there."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise RecordingError(f"{path}: PNG needs the package matplotlib (pip install 'axisgate[files]'); .html needs none") from error
    charts = [_xy_chart(recording, *xy)] if xy else _charts(recording)
    figure = Figure(figsize=(11, 3 * len(charts)), layout="constrained")
    FigureCanvasAgg(figure)
    for place, chart in enumerate(charts, start=1):
        axes = figure.add_subplot(len(charts), 1, place)
        for line in chart.lines:
            axes.plot(line.x, line.y, label=line.name, linewidth=1.0)
        axes.set(title=chart.title, xlabel=chart.x_label, ylabel=chart.y_label)
        if chart.equal:
            axes.set_aspect("equal", adjustable="datalim")
        else:
            for cursor in cursors:
                axes.axvline(cursor, color="#c03030", linestyle="--", linewidth=0.8)
        axes.grid(True, alpha=0.3)
        axes.legend(loc="upper right", fontsize="small")
    figure.savefig(path, dpi=100)


def _charts(recording: Recording) -> list[Chart]:
    units: dict[str, list[Line]] = {}
    for name, unit in zip(recording.names, recording.units, strict=True):
        units.setdefault(unit, []).append(Line(name, recording.time.tolist(), recording.column(name).tolist()))
    return [Chart(", ".join(line.name for line in lines), "s", unit or "1", lines) for unit, lines in units.items()]


def _xy_chart(recording: Recording, x: str, y: str) -> Chart:
    units = dict(zip(recording.names, recording.units, strict=True))
    line = Line(f"{y} over {x}", recording.column(x).tolist(), recording.column(y).tolist())
    return Chart(line.name, f"{x} {units[x]}", f"{y} {units[y]}", [line], equal=units[x] == units[y])


def _table(recording: Recording, cursors: Sequence[float]) -> str:
    if not cursors:
        return ""
    rows = at_cursors(recording, cursors)
    titles = "".join(
        f"<th>{html.escape(name)} {html.escape(unit)}</th>" for name, unit in zip(recording.names, recording.units, strict=True)
    )
    body = "".join("<tr>" + "".join(f"<td>{value:.6g}</td>" for value in row) + "</tr>" for row in rows)
    if len(rows) == 2:
        body += "<tr>" + "".join(f"<td>{after - before:+.6g}</td>" for before, after in zip(*rows, strict=True)) + "</tr>"
    return f"<h2>Cursors</h2><table><tr><th>t s</th>{titles}</tr>{body}</table>"
