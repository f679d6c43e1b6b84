"""Try one axis for the first time (2 mm at 5 % speed and 20 % torque, both directions), or set its zero position."""

import argparse
import json
import time

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.run import slug_of
from gateway.pure.cell.cell import Axis, Cell
from gateway.pure.image.records.cell import AxisFlag
from gateway.registry import DRIVE_FAMILIES
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError, mask_of, running, simulated
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.drives.first_enable import percent
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate axis try cell.toml X                     on the running cell: pre-checks, then both ways
  axisgate axis try demo-402 A1 --sim               the same on emulated drives
  axisgate axis zero cell.toml Z --at 0 --who "A. Fitter"    set the present position to 0.0 and record it
"""
TORQUE_LIMIT = 0x6072  # max torque, 0.1 % of rated


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate axis", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("try", "zero"))
    parser.add_argument("cell", help="cell file, or the name of a shipped one")
    parser.add_argument("axis", help="name of the axis")
    parser.add_argument("--name", help="name of the run, if it differs from the file")
    parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
    parser.add_argument("--at", type=float, default=0.0, help="zero: new value of the present position (default 0)")
    parser.add_argument("--who", default="", help="zero: your name, for the history")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    try:
        axis = cell.axis_named(arguments.axis)
        if arguments.sim:
            with simulated(arguments.cell) as (client, _):
                client.wait_ready()
                found = _try(client, cell, axis) if arguments.what == "try" else _zero(client, cell, axis, arguments.at, arguments.who)
        else:
            with running(arguments.name or slug_of(cell)) as client:
                found = _try(client, cell, axis) if arguments.what == "try" else _zero(client, cell, axis, arguments.at, arguments.who)
    except KeyError as error:
        complain("axis", error.args[0])
        return USAGE
    except ToolError as error:
        complain("axis", error.args[0])
        return FINDING if isinstance(error, NotReady) else ENVIRONMENT
    print(json.dumps(found, indent=1) if arguments.json else found["sentence"])
    return DONE if found["good"] else FINDING


# ---- try -----------------------------------------------------------------------------------------------------------------


def _try(client: ToolClient, cell: Cell, axis: Axis) -> Row:
    """Both ways by `first_enable`; direction, increments per unit and following error in a sentence."""
    row = client.axis(axis.name)
    if int(str(row["flags"])) & (AxisFlag.FAULT | AxisFlag.LOST | AxisFlag.UNCONFIGURED):
        why = row["why"] or fault_words(axis, int(str(row["fault"])), cell.cell.language)
        raise NotReady(f"axis {axis.name} is not ready: {why}")
    mask, first = mask_of(cell, [axis.name]), axis.first_enable
    client.take_over()
    limited = _limit_torque(client, axis, round(percent(first.torque) * 1000))
    way = min(first.travel, (axis.limits.max - axis.limits.min) / 4)
    try:
        client.command("enable", mask)
        start = _at_rest(client, axis.name)
        legs = [_leg(client, axis, mask, leg * way, percent(first.speed)) for leg in (+1.0, -1.0, -1.0, +1.0)]
        end = _at_rest(client, axis.name)
    finally:
        client.command("disable", mask)
        client.command("release_control")
        if limited is not None:
            client.sdo(axis.name, TORQUE_LIMIT, 0, limited)
    return _verdict(axis, way, legs, start, end, limited is not None)


class NotReady(ToolError):
    """The drive reported the reason; nothing was tried."""


def fault_words(axis: Axis, code: int, language: str) -> str:
    """The drive's code in the words of its family."""
    return DRIVE_FAMILIES[axis.drive.type].sentence(code, language)


def _limit_torque(client: ToolClient, axis: Axis, permille: int) -> bytes | None:
    """6072h for the time of the test; the old value, or None for a drive without it."""
    if not DRIVE_FAMILIES[axis.drive.type].objects:
        return None
    before = client.sdo(axis.name, TORQUE_LIMIT)
    client.sdo(axis.name, TORQUE_LIMIT, 0, permille.to_bytes(2, "little"))
    return before


def _at_rest(client: ToolClient, name: str) -> float:
    time.sleep(0.4)
    return float(str(client.axis(name)["actual"]))


def _leg(client: ToolClient, axis: Axis, mask: int, way: float, velocity: float) -> Row:
    """One relative move; worst following error and torque on the way."""
    before = float(str(client.axis(axis.name)["actual"]))
    targets = [way if mask >> n & 1 else 0.0 for n in range(mask.bit_length())]
    answer = client.ask("tool", code="ptp_relative", mask=mask, velocity=velocity, targets=targets, first_try=True)
    lag = torque = 0.0
    end = time.monotonic() + 60.0
    while answer["open"] and time.monotonic() < end:
        time.sleep(0.01)
        row = client.axis(axis.name)
        lag, torque = max(lag, abs(float(str(row["lag"])))), max(torque, abs(float(str(row["torque"]))))
        answer = client.ask("job", job=answer["job"])
    if answer["state"] != "DONE":
        raise ToolError(f"axis {axis.name}: {answer['words']} {answer['detail']}".rstrip())
    return {"asked": way, "moved": _at_rest(client, axis.name) - before, "lag": lag, "torque": torque}


def _verdict(axis: Axis, way: float, legs: list[Row], start: float, end: float, limited: bool) -> Row:
    unit = axis.unit
    per_unit = axis.drive.inc_per_turn * axis.mechanics.ratio / axis.mechanics.feed_per_turn
    missed = max(abs(float(str(leg["moved"])) - float(str(leg["asked"]))) for leg in legs)
    lag, torque = max(float(str(leg["lag"])) for leg in legs), max(float(str(leg["torque"])) for leg in legs)
    same = all(float(str(leg["moved"])) * float(str(leg["asked"])) > 0 for leg in legs)
    good = same and missed < 0.1 * way
    turn = f"direction {'as' if same else 'AGAINST what is'} asked, {per_unit:.2f} increments per {unit}"
    limit = f"torque limited to {axis.first_enable.torque}" if limited else "no torque limit (the booster has none by telegram)"
    sentence = (
        f"axis {axis.name}: {way:g} {unit} both ways at {axis.first_enable.speed}, {limit}: {turn}, missed by at most {missed:.3f} {unit}, "
        f"following error up to {lag:.3f} {unit}, torque up to {100 * torque:.0f} %, back within {abs(end - start):.3f} {unit}; "
        f"{'look at the axis: did it move as your drawing shows?' if good else 'STOP: do not continue'}"
    )
    return {"axis": axis.name, "good": good, "sentence": sentence, "legs": legs, "increments_per_unit": per_unit}


# ---- zero ----------------------------------------------------------------------------------------------------------------


def _zero(client: ToolClient, cell: Cell, axis: Axis, at: float, who: str) -> Row:
    """Set the present position of the axis to `at`; stored next to the cell, with all earlier zeros."""
    row = client.axis(axis.name)
    if int(str(row["flags"])) & (AxisFlag.LOST | AxisFlag.ON):
        raise ToolError(f"axis {axis.name}: take the drive off first; a zero is written at rest, without power")
    if row["placed"]:
        raise ToolError(f"axis {axis.name}: a program has set its position (mach_pos): start the gateway again, then write the zero")
    entry = zeros.entry(cell, axis, float(str(row["actual"])), at, who)
    try:
        path = zeros.append(cell, entry)
    except OSError as error:
        raise ToolError(f"axis {axis.name}: the zero was not written: {error}") from error
    sentence = (
        f"axis {axis.name}: reads {at:g} {axis.unit} here from the next start on (it read {float(str(row['actual'])):.3f}); "
        f"zero_inc {entry['zero_inc']}, entry {len(zeros.history(cell, axis.name))} of {path}"
    )
    return {"axis": axis.name, "good": True, "sentence": sentence, **entry}
