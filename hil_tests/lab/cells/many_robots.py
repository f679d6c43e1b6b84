"""A cell of sixteen robots of two axes, 32 CiA 402 drives on one bus; a program that moves all of them on one clock, and its judge.

Each robot has its own lines: their lengths differ, the share of its way that each has made does not.
"""

import pathlib

import numpy as np

from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM, AXIS, PLANT
from hil_tests.lab.virtual.planned_bench import Driven, off_segment

ROBOTS = 16
MODEL = "feeder"
FEEDER = """format = 1

[robot]
name = "feeder"
kind = "portal"
angles = "rho3"
source = "assumed"

[portal]
letters = "xy"
""" + "".join(
    f"""
[[axis]]
name = "{name}"
unit = "mm"
lower = -500
upper = 500
speed = 300
accel = 1500
jerk = 30000
source = "assumed"
"""
    for name in "XY"
)
LINEAR = {"unit": "mm", "feed": 20.0, "gear": "1:1", "low": -500.0, "high": 500.0, "speed": 300.0, "accel": 1500.0, "jerk": 30000.0}
LINEAR |= {"warn": 8.0, "trip": 10.0, "start": 0.0}
ROUND = 0.01  # m
ROUNDED, FOLLOWED = 25e-6, 1e-3  # m: half an increment of each axis; the drives' own lag


def points(robot: int) -> tuple[tuple[float, float], ...]:
    """(x, y) mm of the corner and of the end of its way from 0, 0."""
    return (100.0 + 10.0 * robot, 5.0 * robot - 40.0), (60.0 + 5.0 * robot, 90.0 + 2.0 * robot)


def names(robots: int = ROBOTS) -> list[str]:
    return [f"r{n}" for n in range(1, robots + 1)]


def program(robots: int = ROBOTS) -> str:
    """All of them over their corners to their ends, and back in one PTP; then the last one alone."""
    text = "program many\n"
    for n, name in enumerate(names(robots)):
        corner, end = (" ".join(f"{value:g}" for value in point) for point in points(n))
        text += f"kinematic {name} {MODEL}\naxes mm mm\nstart 0 0\npoint CORNER pose {corner} 0 0 0 0\npoint END pose {end} 0 0 0 0\n"
        text += "point HOME joints 0 0\n\n"
    every = (" and ".join(f"{name} {what}" for name in names(robots)) for what in ("linear CORNER radius=10", "linear END", "ptp HOME"))
    return text + "".join(f"move {moves}\n" for moves in every) + f"move {names(robots)[-1]} linear CORNER\n"


def to_the_ends(robots: int = ROBOTS) -> str:
    """Move all of them from where they are to their corners."""
    text = program(robots)
    moves = (" and ".join(f"{name} {what}" for name in names(robots)) for what in ("ptp END", "linear CORNER"))
    return text[: text.index("move")] + "".join(f"move {move}\n" for move in moves)


def cell_file(folder: pathlib.Path, robots: int = ROBOTS, more_axes: int = 0, cycle_ms: int = 10) -> pathlib.Path:
    """Written there with its robot and its program; `more_axes`: of no robot."""
    shipped = ARM.read_text()
    head, rest = shipped.split("[robot]", 1)
    drives, plant = rest[rest.index("# ---- drives") :].split("# ---- the emulated machine", 1)
    text = head + "".join(f'[[robot]]\nkinematics = "portal"\nmodel = "{MODEL}.toml"\nname = "{name}"\n\n' for name in names(robots))
    text += '[[program]]\nnumber = 1\nfile = "many.txt"\n\n'
    text += drives[: drives.index("[[axis]]")].replace("cycle_ms = 4", f"cycle_ms = {cycle_ms}")
    axes = [f"{letter}{n}" for n in range(1, robots + 1) for letter in "XY"] + [f"E{n}" for n in range(1, more_axes + 1)]
    tables = [LINEAR | {"name": name, "node": node} for node, name in enumerate(axes, 1)]
    text += "".join(AXIS.format(**table) for table in tables)
    text += f"# ---- the emulated machine{plant[: plant.index('[plant.axis.J1]')]}" + "".join(PLANT.format(**table) for table in tables)
    (folder / f"{MODEL}.toml").write_text(FEEDER)
    (folder / "many.txt").write_text(program(robots))
    path = folder / "many.toml"
    path.write_text(text)
    return path


def judge_lines(made: Driven, robots: int = ROBOTS) -> None:
    """Every robot on its own two lines, rounded at the corner, by set values and mechanics of the emulator's record."""
    for rows, close in ((made.sets, ROUNDED), (made.actual, FOLLOWED)):
        for n in range(robots):
            corner, end = (np.array(point) * 1e-3 for point in points(n))
            places = out(rows)[:, 2 * n : 2 * n + 2]
            on = np.minimum(off_segment(places, (0.0, 0.0), tuple(corner)), off_segment(places, tuple(corner), tuple(end)))
            from_corner = np.linalg.norm(places - corner, axis=1)
            assert float(on[from_corner > ROUND].max()) < close, f"r{n + 1} leaves its lines"
            assert 1e-3 < float(from_corner.min()) < 0.1875 * 2.0 * ROUND + close, f"r{n + 1}: the corner is not rounded"
            assert float(np.linalg.norm(places - end, axis=1).min()) < close, f"r{n + 1} does not arrive"


def out(rows: Array) -> Array:
    """From the start to the ends: the first robot rests nowhere else that long."""
    end = np.array(points(0)[1]) * 1e-3
    return rows[: int(np.argmin(np.linalg.norm(rows[:, :2] - end, axis=1))) + 1]


def judge_one_clock(made: Driven, robots: int = ROBOTS) -> None:
    """On the first line, before any corner, all have made the same share of it."""
    rows = out(made.sets)
    corners = np.array([points(n)[0] for n in range(robots)]) * 1e-3
    gone = np.stack([np.linalg.norm(rows[:, 2 * n : 2 * n + 2], axis=1) / np.linalg.norm(corners[n]) for n in range(robots)], axis=1)
    first = gone[: int(np.argmax(gone.max(axis=1) > 0.85))]
    assert len(first) > 20 and 0.3 < float(first.max()) < 1.0
    assert float(np.ptp(first, axis=1).max()) < 5e-4
