"""From [plant] and [[axis]] of a cell to the settings of the emulated drives: everything reflected to the motor shaft."""

import json
import math
import pathlib

from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings, axis_from_dict, to_dict
from gateway.pure.cell.belts import PlantBelt
from gateway.pure.cell.cell import Axis, Cell, PlantAxis

MULTITURN = 4096  # turns that an absolute encoder of the emulated drives distinguishes


def motor_rad(axis: Axis, position: float) -> float:
    """Motor angle at an axis position in the axis' unit; the encoder's zero is at axis position 0."""
    sign = -1.0 if axis.mechanics.direction == "-" else 1.0
    return sign * position / axis.mechanics.feed_per_turn * axis.mechanics.ratio * 2.0 * math.pi


def servo_settings(axis: Axis, plant: PlantAxis) -> ServoSettings:
    """One emulated drive and its mechanics; the drive trips at half a motor turn beyond the gateway's own lag limit.

    `plant.settings` are the emulator's own settings from the file, unchanged: at the motor shaft.
    """
    settings: dict[str, float] = {"start_rad": motor_rad(axis, plant.start)}
    for name, span in (("reference_switch_{}_rad", plant.reference_switch), ("hard_limit_{}_rad", plant.hard_limits)):
        if span is not None:
            low, high = sorted((motor_rad(axis, span.from_), motor_rad(axis, span.to)))
            ends = ("from", "to") if name.startswith("reference") else ("min", "max")
            settings |= {name.format(ends[0]): low, name.format(ends[1]): high}
    settings["following_error_rad"] = abs(motor_rad(axis, axis.following_error.trip)) + math.pi if axis.following_error else 4.0 * math.pi
    settings |= plant.settings
    return axis_from_dict(settings)


def bus_settings(cell: Cell, bus: str, p5_ms: float) -> BusSettings:
    """All drives of one bus, of whichever family."""
    axes: dict[int, ServoSettings] = {}
    nodes: dict[int, DriveSettings] = {}
    for axis in cell.axis:
        if axis.drive.bus != bus:
            continue
        plant = cell.plant.axis.get(axis.name, PlantAxis()) if cell.plant else PlantAxis()
        servo = servo_settings(axis, plant)
        if axis.drive.module is not None:
            axes[axis.drive.module] = servo
        elif axis.drive.node is not None:
            absolute = MULTITURN if axis.home.by == "none" else 0
            low, high = _probe(axis, plant)
            nodes[axis.drive.node] = DriveSettings(
                servo,
                serial=axis.drive.node,
                multiturn_turns=absolute,
                own_feed_forward=float(servo.speed_feed_forward > 0.0),
                probe_1_from_rad=low,
                probe_1_to_rad=high,
                probe_2_from_rad=low,
                probe_2_to_rad=high,
            )
    return BusSettings(p5_ms, cell.plant.seed if cell.plant else 1, axes, nodes)


def _probe(axis: Axis, plant: PlantAxis) -> tuple[float, float]:
    """Motor angles between which both probe inputs are actuated."""
    if plant.probe is None:
        return -math.inf, -math.inf
    low, high = sorted((motor_rad(axis, plant.probe.from_), motor_rad(axis, plant.probe.to)))
    return low, high


def belt_settings(cell: Cell, bus: str) -> str:
    """The belts with an encoder on a bus, in the form the emulator process reads."""
    tables = []
    for belt in cell.belt:
        if belt.bus != bus:
            continue
        plant = cell.plant.belt.get(belt.name, PlantBelt()) if cell.plant else PlantBelt()
        speed, accel = plant.speed / belt.increment, plant.accel / belt.increment
        table = {"identifier": belt.id, "speed": speed, "accel": abs(accel), "byte": belt.byte, "size": belt.bytes}
        tables.append(table)
    return json.dumps(tables)


def write_settings(cell: Cell, bus: str, folder: pathlib.Path, p5_ms: float) -> pathlib.Path:
    """The file the emulator process is started with."""
    path = folder / f"emulator-{bus}.json"
    path.write_text(json.dumps(to_dict(bus_settings(cell, bus, p5_ms)), indent=1))
    return path
