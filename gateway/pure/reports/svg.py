"""A small writer of charts as inline SVG: lines over a common abscissa, or a plane curve with equal scales.  No dependency."""

import html
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

Scale = Callable[[float], float]
COLOURS = ("#1b6ca8", "#c8553d", "#2f8f5b", "#8a5fb0", "#b8860b", "#4a4a4a", "#0f9aa8", "#a83279")
LEFT, RIGHT, TOP, BOTTOM = 64, 14, 26, 34
MOST_POINTS = 1500  # a line: more would only make the file large


@dataclass(frozen=True, slots=True)
class Line:
    """name: for the legend; x, y: same length; dots: single points instead of a line."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    dots: bool = False
    colour: int | None = None  # number in COLOURS; None: by its place in the chart


@dataclass(frozen=True, slots=True)
class Chart:
    """One drawing; bound: a horizontal line that must not be passed; equal: one scale for both axes."""

    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    bound: float | None = None
    equal: bool = False


def draw(chart: Chart, width: int = 860, height: int = 260) -> str:
    """The chart as an <svg> element."""
    inner_w, inner_h = width - LEFT - RIGHT, height - TOP - BOTTOM
    x_range, y_range = _ranges(chart, inner_w, inner_h)

    def x_of(value: float) -> float:
        return LEFT + inner_w * (value - x_range[0]) / (x_range[1] - x_range[0])

    def y_of(value: float) -> float:
        return TOP + inner_h * (1.0 - (value - y_range[0]) / (y_range[1] - y_range[0]))

    parts = [f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" aria-label="{html.escape(chart.title)}">']
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{inner_w}" height="{inner_h}" class="field"/>')
    for value in ticks(*x_range):
        x = x_of(value)
        parts.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{TOP + inner_h}" class="grid"/>')
        parts.append(f'<text x="{x:.1f}" y="{TOP + inner_h + 14}" text-anchor="middle">{_number(value)}</text>')
    for value in ticks(*y_range):
        y = y_of(value)
        parts.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{LEFT + inner_w}" y2="{y:.1f}" class="grid"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{_number(value)}</text>')
    if chart.bound is not None and y_range[0] <= chart.bound <= y_range[1]:
        y = y_of(chart.bound)
        parts.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{LEFT + inner_w}" y2="{y:.1f}" class="bound"/>')
    for number, line in enumerate(chart.lines):
        parts.append(_curve(line, _colour(line, number), x_of, y_of))
    parts.append(f'<text x="{LEFT}" y="16" class="title">{html.escape(chart.title)}</text>')
    parts.append(f'<text x="{LEFT + inner_w}" y="{height - 4}" text-anchor="end">{html.escape(chart.x_label)}</text>')
    parts.append(f'<text x="4" y="16">{html.escape(chart.y_label)}</text>')
    parts.append(_legend(chart.lines, LEFT + inner_w))
    return "\n".join([*parts, "</svg>"])


def _colour(line: Line, place: int) -> str:
    return COLOURS[(place if line.colour is None else line.colour) % len(COLOURS)]


def _curve(line: Line, colour: str, x_of: Scale, y_of: Scale) -> str:
    if line.dots:
        return "".join(
            f'<circle cx="{x_of(x):.1f}" cy="{y_of(y):.1f}" r="3" fill="{colour}"/>' for x, y in zip(line.x, line.y, strict=True)
        )
    places = thinned(list(zip(line.x, line.y, strict=True)))
    points = " ".join(f"{x_of(x):.1f},{y_of(y):.1f}" for x, y in places)
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.4"/>'


def thinned(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """At most about MOST_POINTS, keeping the lowest and highest of every stretch: peaks stay."""
    if len(points) <= MOST_POINTS:
        return points
    size = math.ceil(2 * len(points) / MOST_POINTS)
    kept: list[tuple[float, float]] = []
    for start in range(0, len(points), size):
        part = range(start, min(start + size, len(points)))
        low, high = min(part, key=lambda k: points[k][1]), max(part, key=lambda k: points[k][1])
        kept += [points[k] for k in sorted({low, high})]
    return [points[0], *kept, points[-1]]


def _ranges(chart: Chart, width: int, height: int) -> tuple[tuple[float, float], tuple[float, float]]:
    xs = [x for line in chart.lines for x in (min(line.x), max(line.x)) if len(line.x)] or [0.0, 1.0]
    ys = [y for line in chart.lines for y in (min(line.y), max(line.y)) if len(line.y)] or [0.0, 1.0]
    if chart.bound is not None and max(ys) > 0.5 * chart.bound:
        ys.append(chart.bound * 1.05)
    x, y = _wide(min(xs), max(xs), 0.0 if not chart.equal else 0.05), _wide(min(ys), max(ys), 0.05)
    if not chart.equal:
        return x, y
    scale = max((x[1] - x[0]) / width, (y[1] - y[0]) / height)
    return _centred(x, scale * width), _centred(y, scale * height)


def _wide(low: float, high: float, margin: float) -> tuple[float, float]:
    if high - low < 1e-12:
        return low - 0.5, high + 0.5
    return low - margin * (high - low), high + margin * (high - low)


def _centred(span: tuple[float, float], size: float) -> tuple[float, float]:
    middle = 0.5 * (span[0] + span[1])
    return middle - 0.5 * size, middle + 0.5 * size


def ticks(low: float, high: float, most: int = 8) -> list[float]:
    """Round numbers inside the range, at most about `most`."""
    raw = (high - low) / most
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(power * k for k in (1, 2, 5, 10) if power * k >= raw)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _number(value: float) -> str:
    return f"{value:.6g}" if abs(value) > 1e-12 else "0"


def _legend(lines: Sequence[Line], right: int) -> str:
    parts, x = [], float(right)
    for number in range(len(lines) - 1, -1, -1):
        name = html.escape(lines[number].name)
        x -= 7.0 * len(lines[number].name) + 22
        parts.append(f'<rect x="{x:.0f}" y="8" width="12" height="8" fill="{_colour(lines[number], number)}"/>')
        parts.append(f'<text x="{x + 16:.0f}" y="16">{name}</text>')
    return "".join(parts)
