"""[[belt]]: names once, eight at most, encoders with unique identifiers, belts that programs name."""

from gateway.assembly.drive_buses import DRIVE_PROTOCOLS
from gateway.checks.context import Context, twice
from gateway.pure.cell.belts import Belt
from gateway.registry import BUS_PROTOCOLS
from protocols.servodyn.plan import SLOTS, SYNC_ID, actual_id, set_id

MOST = 8
DRIVES = range(1, SLOTS + 1)
FORMS = {  # identifiers a bus uses itself; those of CANopen nodes are looked at below
    "servodyn": {SYNC_ID, *map(set_id, DRIVES), *map(actual_id, DRIVES)},
    "canopen": set(range(0x81)),
}
FUNCTIONS = (0x80, 0x180, 0x200, 0x280, 0x300, 0x380, 0x400, 0x480, 0x500, 0x580, 0x600, 0x700)  # of one CANopen node


def belts(check: Context) -> None:
    """Checks beyond a single belt."""
    cell = check.cell
    if len(cell.belt) > MOST:
        check.fault("belt", len(cell.belt), "belts of one cell (P501)", f"0..{MOST}")
    for name, _, _ in twice((each.name, str(n)) for n, each in enumerate(cell.belt)):
        check.fault(f"belt.{name}.name", name, "another belt has this name")
    for number, belt in enumerate(cell.belt, 1):
        _one(check, belt, number)
    if cell.belt and not cell.robot:
        check.fault("belt", "", "belts carry the path of a robot: [robot] with a model is missing")
    if cell.plant is not None:
        known = {each.name for each in cell.belt}
        for name in cell.plant.belt:
            if name not in known:
                check.fault(f"plant.belt.{name}", name, f"no such belt; there is {', '.join(sorted(known)) or 'none'}")


def _moved(check: Context, belt: Belt, where: str) -> None:
    """Axes it carries, and how far (P503)."""
    cell = check.cell
    if not any(belt.factors) or not belt.factor:
        key = "factor" if not belt.factor else "factors"
        check.fault(f"{where}.{key}", getattr(belt, key), "a belt with factors 0 moves nothing (P503)")
    for name, factors in belt.factors_of.items():
        if name not in (belt.robot or tuple(robot.name for robot in cell.robot)):
            check.fault(f"{where}.factors_of", name, "not a robot of this belt", ", ".join(belt.robot))
        elif not any(factors):
            check.fault(f"{where}.factors_of.{name}", list(factors), "a belt with factors 0 moves nothing (P503)")
    if belt.axis:
        _parallel(check, belt, where)


def _parallel(check: Context, belt: Belt, where: str) -> None:
    """An axis parallel to a belt must be endless (rho 3, TO08 section 4)."""
    if check.unknown(f"{where}.axis", belt.axis, "axis"):
        return
    if not next(axis for axis in check.cell.axis if axis.name == belt.axis).modulo:
        hint = "an axis parallel to a belt is endless: modulo in its [[axis]] (P303 = 3, P311); `factors` are for x, y, z"
        check.fault(f"{where}.axis", belt.axis, hint)


def _one(check: Context, belt: Belt, number: int) -> None:
    where, cell = f"belt.{belt.name}", check.cell
    if belt.increment == 0.0:
        check.fault(f"{where}.increment", 0, "an increment must be a distance other than 0", "-100..100, not 0", belt.unit)
    if belt.byte + belt.bytes > 8:
        check.fault(f"{where}.byte", belt.byte, f"{belt.bytes} bytes from here are more than a telegram has", f"0..{8 - belt.bytes}")
    _moved(check, belt, where)
    if not belt.bus:
        if belt.id:
            check.fault(f"{where}.id", belt.id, "an encoder needs `bus`, the drive bus it is on")
        return
    if check.unknown(f"{where}.bus", belt.bus, "bus"):
        return
    bus = next((each for each in cell.bus if each.name == belt.bus), None)
    if bus is None:
        return
    if bus.protocol not in DRIVE_PROTOCOLS:
        check.fault(f"{where}.bus", belt.bus, f"{bus.protocol}: only a drive bus is read in every cycle ({', '.join(DRIVE_PROTOCOLS)})")
    taken = set(FORMS.get(bus.protocol, ()))
    if BUS_PROTOCOLS[bus.protocol].nodes:
        taken |= {
            function + axis.drive.node for function in FUNCTIONS for axis in cell.axis if axis.drive.bus == bus.name and axis.drive.node
        }
    taken |= {other.id for other in cell.belt[: number - 1] if other.bus == belt.bus}
    if belt.id in taken or belt.id == 0:
        check.fault(f"{where}.id", belt.id, f"this identifier of bus {bus.name} is taken by SYNC, a drive or another belt", "1..2047")


CHECKS = (belts,)
