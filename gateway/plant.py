"""From [plant] and [[axis]] of a cell to the settings of the emulated drives: everything reflected to the motor shaft."""

import json
import math
import pathlib

from drivers.emulator.settings import BusSettings, ServoSettings, to_dict
from gateway.cell import Axis, Cell, PlantAxis

RPM = 2.0 * math.pi / 60.0


def motor_rad(axis: Axis, position: float) -> float:
    """Motor angle at an axis position in the axis' unit; the encoder's zero stands at axis position 0."""
    sign = -1.0 if axis.mechanics.direction == "-" else 1.0
    return sign * position / axis.mechanics.feed_per_turn * axis.mechanics.ratio * 2.0 * math.pi


def servo_settings(axis: Axis, plant: PlantAxis) -> ServoSettings:
    """One emulated drive and its mechanics; the drive trips at half a motor turn beyond the gateway's own lag limit."""
    switch = sorted(motor_rad(axis, end) for end in (plant.reference_switch.from_, plant.reference_switch.to)) if plant.reference_switch else None
    trip = abs(motor_rad(axis, axis.following_error.trip)) + math.pi if axis.following_error else 4.0 * math.pi
    return ServoSettings(
        motor_inertia_kgm2=plant.motor_inertia,
        load_inertia_kgm2=plant.load_inertia,
        coulomb_nm=plant.coulomb,
        stiction_nm=1.2 * plant.coulomb,
        viscous_nms_per_rad=plant.viscous,
        gravity_nm=plant.gravity * (-1.0 if axis.mechanics.direction == "-" else 1.0),
        rated_torque_nm=plant.rated_torque,
        torque_limit_nm=plant.max_torque,
        speed_limit_rad_s=plant.max_speed * RPM,
        overspeed_rad_s=1.2 * plant.max_speed * RPM,
        kv_per_s=plant.kv,
        following_error_rad=trip,
        brake_torque_nm=max(2.0 * abs(plant.gravity), plant.rated_torque),
        brake_open_s=plant.brake_delay_ms / 1000.0,
        start_rad=motor_rad(axis, plant.start),
        reference_switch_from_rad=switch[0] if switch else -math.inf,
        reference_switch_to_rad=switch[1] if switch else -math.inf,
    )


def bus_settings(cell: Cell, bus: str, p5_ms: float) -> BusSettings:
    """All drives of one bus."""
    axes = {}
    for axis in cell.axis:
        if axis.drive.bus == bus and axis.drive.module is not None:
            axes[axis.drive.module] = servo_settings(axis, cell.plant.axis.get(axis.name, PlantAxis()) if cell.plant else PlantAxis())
    return BusSettings(p5_ms, cell.plant.seed if cell.plant else 1, axes)


def write_settings(cell: Cell, bus: str, folder: pathlib.Path, p5_ms: float) -> pathlib.Path:
    """The file the emulator process is started with."""
    path = folder / f"emulator-{bus}.json"
    path.write_text(json.dumps(to_dict(bus_settings(cell, bus, p5_ms)), indent=1))
    return path
