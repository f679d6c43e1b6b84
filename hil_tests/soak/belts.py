"""Random programs with synchronous parts, on belts of the three types that cells know, run by the parts that run them in the cycle.

Each program has a part of type 1, 2 or 3 between two PTP moves; the arm, the SCARA and the portal follow belts in directions of their own.
Judged at 1 ms: speed 1.00 of every axis, with types 2 and 3 acceleration 1.02, too (on a belt of type 1 it is not limited in addition to
that of the path, AX-447; it is printed).  The tool is within 0.1 mm of the belt where the last block of type 1 ends, once the robot has
caught up, and of the point of each block of types 2 and 3.
"""

import math
import multiprocessing
import os
import random
from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.cells import arms
from hil_tests.soak.robots import HOME, ROBOTS, STEP
from motion.geometry.conventions import RHO3
from motion.geometry.units import from_si
from motion.planner.trace import Trace
from motion.program.errors import BlockError
from motion.program.text.reader import read
from motion.sync.belts import BeltData, Type
from motion.sync.facts import BeltFacts
from motion.sync.parallel import Carrier

Array = NDArray[np.float64]
INCREMENT = 1e-6  # m: what is judged is the motion, not how fine an encoder counts
PERIOD_S = 1e-3
SPEED, ACCEL = 1.0, 1.02
TRACKING = 1e-4  # m
CAUGHT_S = 1.3  # of a part of type 1: half a second before it begins, and 0.8 s for catching up
AHEAD = 2.0  # periods from a count to the SYNC that activates what was made of it


class Riding(NamedTuple):
    """Of one program: worst shares of the limits of its axes, the largest distance from the belt, why it was refused ("": it ran)."""

    seed: int
    robot: str
    kind: int
    shares: tuple[float, float, float]
    off: float
    refused: str
    text: str

    @property
    def good(self) -> bool:
        quiet = self.kind == Type.PARALLEL.value or self.shares[1] <= ACCEL
        return bool(self.refused) or (self.off <= TRACKING and self.shares[0] <= SPEED and quiet)


class _Program:
    """Its text; `points`: (belt value, place of the tool in the base when the belt has it), m, of blocks that are judged."""

    def __init__(self, seed: int) -> None:
        self.dice = dice = random.Random(seed)
        self.name = ROBOTS[seed % len(ROBOTS)]
        self.kind = Type(1 + seed // len(ROBOTS) % 3)
        self.machine = arms.robot(self.name)
        turn, tilt = dice.uniform(-math.pi, math.pi), dice.choice((0.0, dice.uniform(-0.5, 0.5)))
        self.factors = (math.cos(turn) * math.cos(tilt), math.sin(turn) * math.cos(tilt), math.sin(tilt))
        self.speed = dice.choice((0.02, 0.05, dice.uniform(0.01, 0.2), dice.uniform(0.01, 0.3)))
        self.points: list[tuple[float, Array]] = []
        self.text = self._text()

    def stand(self, share: float) -> tuple[float, ...]:
        places = []
        for axis, home, step in zip(self.machine.limits, HOME[self.name], STEP[self.name], strict=True):
            low, high = max(axis.lower, home - step), min(axis.upper, home + step)
            places.append(min(max(home + share * self.dice.uniform(-step, step), low + 1e-3), high - 1e-3))
        return tuple(places)

    def joints(self, q: tuple[float, ...]) -> str:
        return "joints " + " ".join(f"{from_si(value, axis.unit):.6f}" for value, axis in zip(q, self.machine.limits, strict=True))

    def pose(self, q: tuple[float, ...]) -> tuple[str, Array]:
        pose = self.machine.forward(q)
        return "pose " + " ".join(f"{value:.6f}" for value in RHO3.values(pose)), np.array(pose.position)

    def _text(self) -> str:
        dice, size = self.dice, self.dice.choice((0.15, 0.3, 0.5))
        rows = [
            f"robot {self.name}",
            "angles rho3",
            "axes " + " ".join(axis.unit for axis in self.machine.limits),
            "start " + self.joints(HOME[self.name]).removeprefix("joints "),
            f"ptp {self.joints(self.stand(size))}",
        ]
        rows += self._carried(size) if self.kind is Type.PARALLEL else self._followed(size)
        return "\n".join([*rows, "synchron_end", f"ptp {self.joints(self.stand(size))} speed={dice.uniform(10, 100):.1f}"])

    def _pace(self) -> str:
        dice = self.dice
        return dice.choice(
            ("", f" path={dice.uniform(30, 800):.1f}", f" speed={dice.uniform(20, 100):.1f} accel={dice.uniform(20, 100):.1f}")
        )

    def _carried(self, size: float) -> list[str]:
        dice, rows = self.dice, ["synchron B at=100mm"]
        value, count = 0.1 + dice.uniform(0.0, 0.1), dice.randint(2, 5)
        for n in range(count):
            pose, place = self.pose(self.stand(size))
            rounded = n < count - 1 and dice.random() < 0.5
            corner = f" radius={dice.choice((2, 5, 20))}" if rounded else ""
            kind = dice.choice(("linear", "linear", "ptp"))
            rows.append(f"{kind} {pose} belt={value * 1e3:.4f}mm{self._pace()}{corner}")
            if n == count - 1:
                self.points.append((value, place))
        return rows

    def _followed(self, size: float) -> list[str]:
        dice = self.dice
        value, rows = 0.1, ["synchron B at=100mm"]
        for _ in range(dice.randint(1, 4)):
            pose, place = self.pose(self.stand(size))
            way = self.speed * dice.uniform(0.8, 3.0)
            value += way
            cam = ""
            if self.kind is Type.CAM and dice.random() < 0.7:
                first, last = (dice.uniform(0.05, 0.45) * way * 1e3 for _ in "ab")
                cam = f" camin={first:.3f}mm camout={last:.3f}mm"
            rows.append(f"linear {pose} belt={value * 1e3:.4f}mm{cam}")
            self.points.append((value, place))
        return rows


def ridden(seed: int) -> Riding:
    """One program."""
    made = _Program(seed)
    facts = BeltFacts("B", BeltData(INCREMENT, simulated=made.speed * 1e3), made.kind, 12, {1: Carrier(made.factors)})
    nothing = (0.0, 0.0, 0.0)
    try:
        sections, faults = sections_of(read(made.text), made.machine, (facts,))
        if faults:
            return Riding(seed, made.name, made.kind.value, nothing, 0.0, str(faults[0]), made.text)
        trace = DryRun(made.machine, (facts,), (made.speed,), 4, PERIOD_S).run(sections)
    except BlockError as error:
        return Riding(seed, made.name, made.kind.value, nothing, 0.0, str(error), made.text)
    return Riding(seed, made.name, made.kind.value, arms.shares(made.machine, trace.q, PERIOD_S), _off(made, trace), "", made.text)


def _off(made: _Program, trace: Trace) -> float:
    """Largest distance of the tool from where the belt asks it to be, at the end of each block."""
    way = trace.belts[0]
    first = int(np.argmin(np.abs(trace.t - way.t[0])))
    tool = trace.tool[first : first + len(way.t)]
    value = way.value[: len(tool)] + AHEAD * made.speed * trace.period
    worst = 0.0
    for meant, place in made.points:
        if made.kind is Type.PARALLEL:
            asked = place + np.outer(value - meant, np.array(made.factors))
            away = np.linalg.norm(tool - asked, axis=1)
            nearest = int(away.argmin())
            worst = float(away[nearest]) if way.t[nearest] > CAUGHT_S else 0.0  # a part so short never catches up
        else:
            worst = max(worst, float(np.linalg.norm(tool - place, axis=1).min()))
    return worst


def rides(count: int, seed: int, processes: int) -> tuple[list[str], list[str]]:
    """(figures in words, what was wrong) of so many programs."""
    with multiprocessing.Pool(processes, os.nice, (10,)) as pool:
        found = list(pool.imap(ridden, range(seed * 1_000_000, seed * 1_000_000 + count), chunksize=1))
    words, wrong = [], [f"ride {one.seed}: {one.shares} x limit, {one.off * 1e6:.1f} um off; {one.text!r}" for one in found if not one.good]
    for kind in Type:
        ran = [one for one in found if one.kind == kind.value and not one.refused]
        speed, accel, jerk = (max((one.shares[n] for one in ran), default=0.0) for n in range(3))
        off = max((one.off for one in ran), default=0.0)
        words.append(
            f"belts of type {kind.value}: {len(ran)}; v {speed:.4f}, a {accel:.4f}, jerk {jerk:.4f} x limit, {off * 1e6:.1f} um off"
        )
    refused = Counter(one.refused.split(":", 1)[-1].strip()[:40] for one in found if one.refused)
    words += [f"  not run: {number} {reason}" for reason, number in refused.most_common(5)]
    if 2 * sum(refused.values()) > count > 1:
        wrong.append(f"belts: {sum(refused.values())} of {count} programs were not run")
    return words, wrong
