"""A recording of a living drive bus in any layout, made in virtual time by our drive objects and the emulated boosters.

The layout is a DBC text; what drives and boosters say goes through its codec, so only the bytes differ from one layout to the next.
"""

import math
from dataclasses import dataclass, field

from drivers.drives.family import Demand
from drivers.drives.servodyn import Drive, DriveSettings, Power
from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import ServodynSlave
from protocols.base.dbc import compile_dbc
from protocols.base.machine import Frame, Ns
from protocols.servodyn.codec import SYNC, ActualValue, Codec, SetValue

START: Ns = 1_700_000_000_000_000_000
P5: Ns = 4_000_000
ON_S, OFF_S, AGAIN_S, END_S = 0.3, 4.2, 4.9, 8.4  # drives on, off, on again, off again
MOVES = ((0.9, 1.2, 1.0), (2.3, 1.5, -2.0), (5.4, 1.3, 1.6), (6.9, 1.2, -0.8))  # begin, duration, share of the axis' way
WAYS = (60.0, -25.0, 90.0)  # rad of the motor


@dataclass
class Recording:
    """`frames` as they were on the bus; the true values, one for each cycle and axis."""

    frames: list[Frame] = field(default_factory=list)
    set_inc: list[list[int]] = field(default_factory=list)
    actual: list[list[ActualValue]] = field(default_factory=list)


def record(dbc: str, axes: int = 3, seconds: float = 8.8) -> Recording:
    """Switch on, move, switch off, and once more; the reference switch of each axis is passed."""
    codec = Codec(compile_dbc(dbc))
    widths = {signal.name: signal.high for layout in compile_dbc(dbc).values() for signal in layout.signals}
    switch = {n: (0.2 * WAYS[n - 1], 0.45 * WAYS[n - 1]) for n in range(1, axes + 1)}
    settings = {
        n: ServoSettings(start_rad=0.4 * n, reference_switch_from_rad=min(switch[n]), reference_switch_to_rad=max(switch[n]))
        for n in range(1, axes + 1)
    }
    slave = ServodynSlave(BusSettings(4.0, 1, settings), codec)
    drives = [Drive(DriveSettings(jump_inc=1 << 20, step_inc=1 << 20)) for _ in range(axes)]
    bases = [0] * axes
    burst, out = [SYNC, *(codec.encode_set(n, SetValue()) for n in range(1, axes + 1))], Recording()
    for cycle in range(round(seconds * 1e9 / P5)):
        now, t = START + cycle * P5, cycle * P5 * 1e-9
        stamped = [frame._replace(stamp_ns=now + 130_000 * n) for n, frame in enumerate(burst)]
        slave.receive(stamped, now)
        answers = [frame._replace(stamp_ns=now + 1_000_000 + 130_000 * n) for n, frame in enumerate(slave.take_output())]
        out.frames += stamped + answers
        actual = [codec.decode_actual(frame)[1] for frame in answers[-axes:]]
        burst, sets = [SYNC], []
        for n, drive in enumerate(drives):
            if drive.power is not Power.ENABLED:
                bases[n] = drive.position_inc
            way, speed = _path(t, WAYS[n])
            on = ON_S + 0.02 * n < t < OFF_S or AGAIN_S + 0.02 * n < t < END_S
            demand = Demand(on, False, bases[n] + round(way * 16384 / (2 * math.pi)), speed * 60 / (2 * math.pi), t > 2.0)
            value = drive.step(actual[n], demand)
            burst.append(codec.encode_set(n + 1, value._replace(life=value.life & widths["life"])))
            sets.append(value.position_inc)
        out.set_inc.append(sets)
        out.actual.append(actual)
    return out


def _path(t: float, way: float) -> tuple[float, float]:
    """(rad, rad/s) since the drives came on last: moves with a sine squared of speed."""
    place = speed = 0.0
    for begin, duration, share in MOVES:
        if (begin > OFF_S) != (t > OFF_S):
            continue
        u = min(max((t - begin) / duration, 0.0), 1.0)
        place += share * way * (u - math.sin(2 * math.pi * u) / (2 * math.pi))
        speed += share * way / duration * (1 - math.cos(2 * math.pi * u)) if 0.0 < u < 1.0 else 0.0
    return place, speed


def layout(set_bits: str, actual_bits: str, axes: int = 3) -> str:
    """A DBC text; signals as "name start|bits+, ..." ("-" for signed)."""
    lines = ["BO_ 100 SYNC: 0 BUS"]
    for n in range(1, axes + 1):
        for kind, number, signals in (("SET", 200 + 10 * n, set_bits), ("ACT", 600 + 10 * n, actual_bits)):
            lines.append(f"BO_ {number} {kind}_{n}: 8 BUS")
            lines += [
                f' SG_ {name} : {place[:-1]}@1{place[-1]} (1,0) [0|0] "" BUS'
                for name, place in (each.split() for each in signals.split(","))
            ]
    return "\n".join(lines)
