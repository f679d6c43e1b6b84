"""Figure emulator.six_axes_cpu: what six emulated drives cost, telegrams, states and record included; against the bare step in C."""

import json
import pathlib
import statistics
import subprocess
import time
from math import cos, sin

from drivers.emulator.servo.model import Servo, constants
from drivers.emulator.servo.settings import ServoSettings
from gateway.tools.progress import steps
from hil_tests.lab.virtual.servodyn_bus import DriveBus
from protocols.base.machine import Frame

REFERENCE = pathlib.Path(__file__).resolve().parents[2] / "build" / "servo_ref"
GOAL_PERCENT = 12.0
BLOCKS, BLOCK_CYCLES, C_CYCLES = 6, 500, 25_000  # 2 s and 100 s of simulated time at P5 = 4 ms
ALL_ON = ServoSettings(  # every effect has something to do
    gravity_nm=1.0,
    gravity_arm_nm=0.5,
    gravity_arm_gear=50.0,
    gravity_arm_phase_rad=0.3,
    torque_noise_nm=0.05,
    following_error_rad=60.0,
    reference_switch_from_rad=1.0,
    reference_switch_to_rad=3.0,
    hard_limit_min_rad=-1000.0,
    hard_limit_max_rad=1000.0,
    soft_limit_min_inc=-2_000_000,
    soft_limit_max_inc=2_000_000,
)


def reference(axes: int, cycles: int, settings: ServoSettings) -> tuple[float, float]:
    """CPU seconds and last position of axis 1, in C.  Raises OSError or CalledProcessError when it does not run."""
    numbers = [repr(value) for value in constants(settings)]
    done = subprocess.run([str(REFERENCE), str(axes), str(cycles), *numbers], check=True, capture_output=True, text=True)
    found = json.loads(done.stdout)
    return float(found["cpu_s"]), float(found["position_rad"])


def same_in_python(cycles: int, settings: ServoSettings) -> float:
    """Last position of the same scenario in the Python model."""
    servo = Servo(settings)
    servo.open_brake()
    servo.hold()
    for k in range(cycles):
        servo.follow(20.0 * 16384.0 * sin(0.004 * k), 0, 4_000_000, 0.0)
        servo.run_to(64 * (k + 1))
    return servo.position_rad


class Load:
    """Six moving axes in bus time; only what the emulator does is counted, not the master."""

    def __init__(self) -> None:
        self._bus = DriveBus(*[ALL_ON] * 6)
        self._bus.enable()
        for number in range(1, 7):
            self._bus.move(lambda t: 150_000.0 * (1.0 - cos(1.5 * t)), number)
            self._bus.want[number].limit_switch = True

    def block(self, cycles: int) -> float:
        """CPU seconds of the emulator."""
        bus, spent = self._bus, 0.0
        for _ in range(cycles):
            began = time.process_time_ns()
            bus.slave.receive([Frame(100, b"", bus.now)], bus.now)
            frames = bus.slave.take_output()
            spent += time.process_time_ns() - began
            bus.hear(frames)
            values = bus.set_values()
            began = time.process_time_ns()
            bus.slave.receive(values, values[-1].stamp_ns)
            bus.slave.prepare()
            bus.slave.wake(values[-1].stamp_ns)
            bus.slave.take_record()
            spent += time.process_time_ns() - began
            bus.now += bus.p5
        assert all(value.enabled for value in bus.actual.values()), bus.actual
        return spent * 1e-9


def six_axes_cpu() -> dict[str, object]:
    """Percent of a core for six axes in real time: median of the blocks."""
    load, python, native = Load(), [], []
    load.block(100)
    for _ in steps("emulator", range(BLOCKS)):
        python.append(load.block(BLOCK_CYCLES) / (BLOCK_CYCLES * 0.004) * 100.0)
        native.append(reference(6, C_CYCLES, ALL_ON)[0] / (C_CYCLES * 0.004) * 100.0)
    value, against = statistics.median(python), statistics.median(native)
    return {
        "figure": "emulator.six_axes_cpu",
        "value": round(value, 3),
        "unit": "% of a core",
        "reference": "bare servo step in C (servo_ref), no bus",
        "reference_value": round(against, 4),
        "ratio": round(value / against, 1),
        "goal": f"<= {GOAL_PERCENT:g}",
        "met": value <= GOAL_PERCENT,
    }


def figures() -> list[dict[str, object]]:
    return [six_axes_cpu()]


if __name__ == "__main__":
    print(json.dumps(figures(), indent=1))
