"""Drives and the protocols of their buses: `type` of the drive of an [[axis]], `protocol` of a [[bus]]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.registry.rows import table

if TYPE_CHECKING:
    from drivers.drives.family import BusFamily, DriveMaker
    from gateway.pure.buses.load import Traffic
    from gateway.pure.cell.axes import Axis
    from gateway.pure.cell.cell import Bus, Cell


@dataclass(frozen=True, slots=True)
class DriveFamily:
    """Family of the drive of an axis."""

    name: str
    words: str
    protocol: str  # of its bus
    address: str  # key of its number on the bus
    settings: "Callable[[Axis, int, float], DriveMaker]"  # axis, largest step of one cycle in increments, cycle in ms
    sentence: Callable[[int, str], str]  # fault code, language
    objects: bool = False  # an object dictionary: data sheet, SDO, serial number, stop option, touch probe
    boosted: bool = False  # a SERVODYN booster: machine parameters of the rho 3 reach it, its bus' layout is its data sheet
    homes: bool = False  # references itself where home.by = "drive"


def _cia402_settings(axis: "Axis", step_inc: int, p5_ms: float) -> "DriveMaker":
    from drivers.drives.cia402 import Cia402Settings

    return Cia402Settings(
        jump_inc=axis.drive.inc_per_turn // 2,
        step_inc=step_inc,
        timeout_cycles=round(5000 / p5_ms),
        homing_cycles=round(axis.home.timeout_s * 1000 / p5_ms),
        mode_cycles=round(2000 / p5_ms),
    )


def _servodyn_settings(axis: "Axis", step_inc: int, p5_ms: float) -> "DriveMaker":
    from drivers.drives.servodyn import DriveSettings

    return DriveSettings(step_inc=step_inc, timeout_cycles=round(5000 / p5_ms), brake=axis.brake != "none")


def _cia402_sentence(code: int, language: str) -> str:
    from drivers.drives import cia402_words

    return cia402_words.sentence(code, language)


def _servodyn_sentence(code: int, language: str) -> str:
    from drivers.drives import servodyn_words

    return servodyn_words.sentence(code, language)


DRIVE_FAMILIES = table(
    DriveFamily("servodyn", "SERVODYN", "servodyn", "module", _servodyn_settings, _servodyn_sentence, boosted=True),
    DriveFamily("cia402", "CiA 402", "canopen", "node", _cia402_settings, _cia402_sentence, objects=True, homes=True),
)


@dataclass(frozen=True, slots=True)
class BusProtocol:
    """Protocol of a CAN bus."""

    name: str
    axis_bytes: int  # of one frame of an axis
    family: "Callable[[Cell, Bus, int], BusFamily]"  # cell, bus, cycle in ms
    traffic: "Callable[[Cell, Bus], list[Traffic]]"
    clocked: bool = True  # its cycle is the clock of the cell
    nodes: bool = False  # CANopen: nodes, heartbeats, SDO
    boosted: bool = False  # SERVODYN: the layout is axisgate's own and needs evidence; P5 is its cycle
    blocks: bool = False  # nothing but I/O blocks of the rho 3 (P30)


def _canopen_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.drive_buses import canopen_family

    return canopen_family(cell, bus, p5_ms)


def _servodyn_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.drive_buses import servodyn_family

    return servodyn_family(cell, bus)


def _block_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.rho3_buses import with_rho3

    return with_rho3(cell, bus, None)


def _canopen_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import canopen_traffic

    return canopen_traffic(cell, bus)


def _servodyn_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import servodyn_traffic

    return servodyn_traffic(cell, bus)


def _block_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import block_traffic

    return block_traffic(cell, bus)


BUS_PROTOCOLS = table(
    BusProtocol("servodyn", 8, _servodyn_family, _servodyn_traffic, boosted=True),
    BusProtocol("canopen", 6, _canopen_family, _canopen_traffic, nodes=True),  # controlword + position, statusword + position
    BusProtocol("rho3-io", 6, _block_family, _block_traffic, clocked=False, blocks=True),
)
