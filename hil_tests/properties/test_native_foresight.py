"""Foresight in C against its twin in Python, along whole paths with random orders: the same bit for bit in every period (AX-609)."""

import pickle
import random
from collections import Counter
from typing import ClassVar

import numpy as np
import pytest

from gateway.cycle.native.built import PYTHON_ONLY
from gateway.cycle.native.foresight import Found, QuickForesight
from gateway.cycle.native.quick import NativeParts
from gateway.recording.states import Snapshots, Start, carry_over, frozen
from hil_tests.bench.online_figures import loaded, random_pieces
from hil_tests.lab.cells.motion_paths import MS, Array, portal_limits, u_arm
from hil_tests.lab.cells.native import native_parts
from hil_tests.soak import motion as soak
from motion.execution.stepper import Stepper
from motion.execution.timed import TimedPiece
from motion.planner.commit import timed_pieces
from motion.timing.choice import assembled
from motion.timing.foresight import Foresight
from motion.timing.jerk import jerk_limited
from motion.timing.track import Part, Rows, Span, Track, Turn
from motion.timing.window import Window

pytestmark = pytest.mark.cref


@pytest.fixture(scope="module", autouse=True)
def native() -> None:
    assert native_parts().foresight is QuickForesight


class Twin(Foresight):
    """In the state another one is in, nothing that changes shared."""

    def __init__(self, track: Track, period_s: float) -> None:
        super().__init__(track, period_s)
        self.prepare()

    def now_as(self, other: Foresight) -> None:
        self.prepare()
        self.begun, self._steady, self._foreseen = other.begun, other._steady, other._foreseen.copy()

    @property
    def foreseen(self) -> Array:
        return self._foreseen


class SideBySide(QuickForesight):
    """Everything twice, the second time in Python."""

    met: ClassVar[Counter[str]] = Counter()

    def __init__(self, track: Track, period_s: float) -> None:
        super().__init__(track, period_s)
        self._twin = Twin(track, period_s)

    def most(self, span: Span, omega: float, left: float, u: float) -> tuple[float, float]:
        found = super().most(span, omega, left, u)
        assert found == span.most(omega, left, u)
        self.met["most"] += 1
        return found

    def _found(self, seen: Window, first: int, past: int, *now: float) -> Found:
        found = super()._found(seen, first, past, *now)
        self.met["asked for"] += found[2] is not None
        return found

    def step(self, tau: float, w: float, u: float, wanted: float) -> float:
        self._twin.now_as(self)
        c = super().step(tau, w, u, wanted)
        asked, at = self._twin.step(tau, w, u, wanted), f"tau {tau}, omega {w}, u {u}, wanted {wanted}"
        assert (c, self.room) == (asked, self._twin.room), at
        assert np.array_equal(self._foreseen, self._twin.foreseen), at
        kinds = {"turning": w * wanted < 0.0, "back": w < 0.0, "axes turn": bool(self._track.turns), "coarse": self.horizon.apart > self._h}
        self.met.update(["step", *(name for name, is_so in kinds.items() if is_so)])
        return c


def rides(pieces: list[TimedPiece], axes: int, seed: int) -> Counter[str]:
    """What was met on the way."""
    SideBySide.met.clear()
    soak.ordered(loaded(pieces, axes, MS, SideBySide), random.Random(seed))
    return SideBySide.met


def test_the_same_along_programs_with_random_orders() -> None:
    met: Counter[str] = Counter()
    for seed in (1_000_001, 1_000_003, 1_000_005, 1_000_006):
        met += rides(soak.pieces_of(seed), 3, seed)
    assert met["most"] > 20 and met["step"] > 100


def test_the_same_on_six_axes() -> None:
    legs, corners, limits = u_arm(0.0125)
    path = assembled(legs, corners)
    pieces = timed_pieces(path, limits, jerk_limited(path, limits))
    met = sum((rides(pieces, 6, seed) for seed in range(6)), Counter[str]())
    assert met["step"] > 500


@pytest.mark.parametrize(("accel", "jerk"), [(20.0, 200.0), (5.0, 50.0), (3.0, 30.0)])
def test_the_same_where_places_lie_several_periods_apart_and_axes_turn_back_between_them(accel: float, jerk: float) -> None:
    limits = portal_limits(2.0, accel, jerk)
    met: Counter[str] = Counter()
    for seed in range(4):
        met += rides(random_pieces(random.Random(seed), limits, 3), 3, seed + 100)
    assert met["coarse"] == met["step"] > 400
    assert met["axes turn"] > 200 and met["back"] > 30 and met["turning"] > 10 and met["asked for"] > 0


def wild(dice: np.random.Generator, track: Track) -> Rows:
    """Rows no path has: calm and heavy axes beside one another, and axes that turn back anywhere."""
    count = 1200
    table = np.zeros((len(Part), track.columns, count), dtype=np.float32)
    heavy = 10.0 ** dice.uniform(-1.0, 1.0, (track.columns, 1))
    table[Part.REACH] = heavy * dice.uniform(2.0, 40.0, table.shape[1:])
    table[Part.PULL] = heavy * dice.uniform(50.0, 1500.0, table.shape[1:])
    for part, most in ((Part.BEND, 30.0), (Part.LEAN, 40.0), (Part.MEAN, 800.0), (Part.TWIST, 800.0)):
        table[part] = dice.normal(0.0, most, table.shape[1:]) * dice.choice([0.0, 0.1, 1.0], (track.columns, 1))
    taus = np.sort(dice.uniform(0.0, count * track.step, 40))
    turns = [Turn(float(tau), 10.0 ** dice.uniform(-2.0, 1.0), -float(dice.uniform(0, 50)), float(dice.uniform(0, 50))) for tau in taus]
    return Rows(0, table, bytes(count), turns)


@pytest.mark.parametrize("ramp", [0.002, 0.02, 0.1])
def test_the_same_on_rows_no_path_has(ramp: float) -> None:
    for seed in range(120):
        dice = np.random.default_rng(seed)
        track = Track(int(dice.integers(1, 8)), MS)
        track.ramp = ramp
        track.append(wild(dice, track))
        ahead = SideBySide(track, MS)
        tau, wanted = float(dice.uniform(0.0, 0.25)), float(dice.choice([0.0, 0.3, 1.0, -1.0]))
        omega = float(dice.choice([0.0, 1.0, *dice.uniform(-0.2, 1.0, 2)]))
        u = float(dice.choice([0.0, dice.normal(0.0, 3.0)]))
        for _ in range(6):
            c = ahead.step(tau, omega, u, wanted)
            tau, omega = tau + MS * omega, min(max(omega + MS * u, -1.0), 1.0)
            u = min(max(u + MS * c, -ahead.horizon.most_u), ahead.horizon.most_u)


def test_what_is_not_as_it_was_made_is_refused() -> None:
    part = QuickForesight.part
    ahead, rows = part.ahead(2, 6, MS, MS, 20.0, 400.0, 2.0), np.zeros((6, 2, 40))
    now = (1000.0, np.zeros(6), False, 0.0, 1.0, 0.0, 0.5, None)
    assert part.step(ahead, np.ones((6, 2, 40)), 0, 40, 0, 40, *now)[2] is None
    for bad in (
        (ahead, rows, 0, 41, 0, 41, *now),
        (ahead, rows, 0, 0, 0, 40, *now),
        (ahead, rows, 0, 40, 0, 40, 1000.0, np.zeros(5), *now[2:]),
        (ahead, rows, 0, 40, 0, 40, *now[:-1], 7),
    ):
        with pytest.raises(ValueError):
            part.step(*bad)
    for columns, places in ((0, 6), (2, 2)):
        with pytest.raises(ValueError):
            part.ahead(columns, places, MS, MS, 20.0, 400.0, 2.0)
    with pytest.raises(ValueError):
        part.most(np.zeros((5, 2, 40)), 1.0, 0.5, 0.0)


def test_whoever_asks_for_python_looks_ahead_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON_ONLY, "1")
    assert NativeParts().foresight is Foresight


def test_a_recording_keeps_the_twin_in_the_same_state() -> None:
    """A cell recorded with C is played without."""
    stepper, fresh, state = loaded(soak.pieces_of(1_000_003), 3, MS, QuickForesight), Stepper(3, MS, (0.0, 0.0, 0.0)), None
    while "'begun': True" not in str(state):  # a change of speed that is no matter of phases is under way
        stepper.set_override(0.3 if stepper.override == 1.0 else 1.0)
        for _ in range(40):
            stepper.step()
        state = kept(stepper)
    assert "motion.timing.foresight:Foresight" in str(state) and "NativeParts" not in str(state)
    played = carry_over(state, kept(fresh), fresh, [])
    assert all(played.step() == stepper.step() for _ in range(400))


def kept(stepper: Stepper) -> object:
    """As a recording writes it."""
    return frozen(pickle.loads(Snapshots().take(Start(stepper, [], [], []))).core)
