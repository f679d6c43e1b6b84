"""Find drives on a bus (scan), start one and pin its identity (commission), measure how they stop at bus loss (loss-test)."""

import argparse
import datetime
import json
import pathlib
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from drivers.drives.cia402_manual import ManualError
from drivers.ports.base import PortError
from gateway.pure.cell.cell import Axis, Bus, Cell
from gateway.registry import BUS_PROTOCOLS, DRIVE_FAMILIES
from gateway.tools.cell_argument import load
from gateway.tools.client import UNHURRIED_MS, ToolError, running, simulated
from gateway.tools.command_support import BANNER, DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.drives.first_enable import TEXT, confirm, unconfirmed
from gateway.tools.usage_language import complain

if TYPE_CHECKING:
    from gateway.tools.drives.loss_test import Stop

EXAMPLES = """examples:
  axisgate drive scan socketcan:can0                 nodes 1..127 with identity; listens first, writes nothing
  axisgate drive commission cell.toml X              start-up of one drive as the cell would do it, and the line that pins it
  axisgate drive commission demo-402 A2 --sim        the same on emulated drives
  axisgate drive commission cell.toml X --mode pp --way 2    and then 2 mm (or deg) in profile position; also pv, hm, ip
  axisgate drive loss-test demo-402                  stop time and distance when SYNC, heartbeat or the gateway is lost (emulated drives)
  axisgate drive loss-test cell.toml --running       the cell that runs: its cycle ends in a move; measures, writes last_stop_test
"""
LOCAL = "broker:"  # a bus of this computer: no real drives
AGREED = "THE AXES MAY MOVE"
PROFILES = {401: "I/O", 402: "drive", 406: "encoder"}


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate drive", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("scan", "commission", "loss-test"))
    parser.add_argument("place", metavar="CELL", help="the cell, or its name; scan also accepts a CAN port (socketcan:can0, broker:NAME)")
    parser.add_argument("axis", nargs="?", help="commission: name of the axis")
    parser.add_argument("--port", help="scan, commission: CAN port in place of the cell's")
    parser.add_argument("--beside", action="store_true", help="scan: also if another master is on the bus")
    parser.add_argument("--sim", action="store_true", help="commission: emulated drives on a separate bus, no hardware")
    parser.add_argument("--mode", choices=("pp", "pv", "hm", "ip"), help="commission: move once by SDO in this mode, at first_enable speed")
    parser.add_argument("--way", type=float, help="commission --mode: distance in the unit of the axis (default: first_enable travel)")
    parser.add_argument("--lose", choices=("gateway", "sync", "heartbeat"), action="append", help="loss-test: only this (default: all)")
    parser.add_argument("--speed", type=float, default=50.0, help="loss-test: %% of the axes' speed (default %(default)s)")
    parser.add_argument("--running", action="store_true", help="loss-test: use the running cell; its real drives move; only --lose gateway")
    parser.add_argument("--name", help="loss-test --running: name of the run, if it differs from the file")
    parser.add_argument("--p5", type=int, help="loss-test: cycle in ms instead of the cell's")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(), help="loss-test: folder for JSON and HTML")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    try:
        if arguments.what == "scan":
            return _scan_place(arguments)
        cell = load(arguments.place)
        if isinstance(cell, int):
            return cell
        if arguments.what == "commission":
            return _commission(cell, arguments)
        return _loss_test_running(cell, arguments) if arguments.running else _loss_test(cell, arguments)
    except (PortError, ToolError, ManualError) as error:
        complain(f"drive {arguments.what}", error)
        return ENVIRONMENT


def _scan_place(arguments: argparse.Namespace) -> int:
    """A CAN port, or every CANopen bus of a cell, at --port or at the port the cell names."""
    if ":" in arguments.place and not arguments.place.endswith(".toml"):
        return _scan(arguments.place, arguments)
    cell = load(arguments.place)
    if isinstance(cell, int):
        return cell
    buses = [bus for bus in cell.bus if BUS_PROTOCOLS[bus.protocol].nodes]
    if not buses:
        complain("drive scan", f"{arguments.place} has no CANopen bus; SERVODYN boosters answer no scan")
        return USAGE
    simulated = [bus.name for bus in buses if bus.simulated and not arguments.port]
    if simulated:
        words = f'bus {simulated[0]} has port = "sim"; name one: axisgate drive scan {arguments.place} --port socketcan:can0'
        complain("drive scan", words)
        return USAGE
    return max(_scan(arguments.port or bus.port, arguments) for bus in buses)


def _scan(url: str, arguments: argparse.Namespace) -> int:
    """Listen first: SDO requests of two clients would receive each other's answers."""
    from gateway.links.canopen.listen_first import refuse_other_master
    from gateway.tools.drives.without_cycle import direct, scan

    with direct(url) as link:
        if not arguments.beside:
            refuse_other_master(link.port, url, "canopen", ", or ask anyway with --beside")
        found = scan(link)
    if arguments.json:
        print(json.dumps(found))
    else:
        for row in found:
            profile = int(str(row.get("type", 0))) & 0xFFFF
            numbers = " ".join(f"{name} {int(str(row.get(name, 0))):#010x}" for name in ("vendor", "product", "revision"))
            print(f"node {row['node']:>3}: {PROFILES.get(profile, f'profile {profile}')}, {numbers}, serial {row.get('serial', '?')}")
        print(f"{len(found)} nodes answer on {url}")
    return DONE if found else FINDING


def _bus_of(cell: Cell, name: str) -> Bus:
    return next(bus for bus in cell.bus if bus.name == name)


def _commission(cell: Cell, arguments: argparse.Namespace) -> int:
    from gateway.assembly.simulated_drives import simulated_drives

    axes = {axis.name: axis for axis in cell.axis if DRIVE_FAMILIES[axis.drive.type].objects}
    axis = axes.get(arguments.axis or "")
    if axis is None:
        complain("drive commission", f"name a CiA 402 axis of the cell: {', '.join(axes) or 'it has none'}")
        return USAGE
    bus = _bus_of(cell, axis.drive.bus)
    if arguments.sim or (arguments.port is None and bus.simulated):
        with simulated_drives(cell, bus) as url:
            return _commission_on(cell, bus, axis, url, arguments)
    return _commission_on(cell, bus, axis, arguments.port or bus.port, arguments)


def _commission_on(cell: Cell, bus: Bus, axis: Axis, url: str, arguments: argparse.Namespace) -> int:
    from gateway.assembly.canopen_nodes import node_plans
    from gateway.links.canopen.listen_first import refuse_other_master
    from gateway.links.canopen.master import Health
    from gateway.tools.drives.without_cycle import IP_PERIOD_MS, direct, inc_to_unit, move_plan, start_up

    plan = dict(node_plans(cell, bus, cell.cycle_ms, simulated=url.startswith(LOCAL)))[axis.name]
    if arguments.mode == "ip":
        plan = replace(plan, period_us=IP_PERIOD_MS * 1000)  # the clock of the tool's own SYNC
    if arguments.mode and not _may_move(cell, url):
        return ENVIRONMENT
    with direct(url) as link:
        refuse_other_master(link.port, url, "canopen")
        node, moved = start_up(link, axis.name, plan, move_plan(axis, arguments.mode, arguments.way) if arguments.mode else None)
    booted = node.booted
    if node.health is not Health.READY or booted is None:
        print(f"axis {axis.name}, node {plan.node}: {node.health.value}: {node.why}", file=sys.stderr)
        return FINDING
    identity = booted.identity
    if moved is not None:
        before, after = inc_to_unit(axis, moved.start_inc), inc_to_unit(axis, moved.end_inc)
        outcome = f"moved it by {after - before:.3f} {axis.unit}"
        if arguments.mode == "hm":  # its zero has jumped: a difference would be no way
            outcome = f"found its home; it reads {after:.3f} {axis.unit}, before it read {before:.3f}"
        print(f"axis {axis.name}: {arguments.mode.upper()} {outcome}; switched off again", file=sys.stderr)
    if arguments.json:
        identified = {
            "axis": axis.name,
            "node": plan.node,
            "serial": identity.serial,
            "vendor": identity.vendor,
            "product": identity.product,
        }
        print(json.dumps({**identified, "options": booted.options, "notes": booted.notes}))
        return DONE
    options = ", ".join(f"{name} {value}" for name, value in booted.options.items())
    print(f"axis {axis.name}, node {plan.node}: starts up; mode {booted.mode} (CSP); its stops (option codes): {options}")
    for note in booted.notes:
        print(f"  note: {note}")
    if not identity.serial:
        print(f"its serial number (1018h:04) is {identity.serial}: it has none that pins it; another drive of its type is not noticed")
    else:
        print(
            f'pin it in the cell:  drive = {{ type = "cia402", bus = "{bus.name}", node = {plan.node}, serial = "{identity.serial}", .. }}'
        )
    print(f"next: axisgate run CELL, then: axisgate axis try CELL {axis.name}")
    return DONE


def _may_move(cell: Cell, url: str) -> bool:
    """On metal only after the confirmation before the first enable."""
    axes = [] if url.startswith(LOCAL) else unconfirmed(cell)
    if not axes:
        return True
    if not sys.stdin.isatty():
        print(f"{TEXT}\naxisgate drive: not confirmed for {', '.join(axes)}; start it at a terminal", file=sys.stderr)
        return False
    return confirm(cell, axes, input, print)


def _loss_test(cell: Cell, arguments: argparse.Namespace) -> int:
    from gateway.tools.drives import loss_test as losstest

    wanted = arguments.lose or losstest.losses_of(cell)
    impossible = [loss for loss in wanted if loss not in losstest.losses_of(cell)]
    if impossible:
        complain("drive loss-test", f"this cell's drives watch {' and '.join(losstest.losses_of(cell))} only")
        return USAGE
    print(BANNER, file=sys.stderr)
    stops: list[losstest.Stop] = []
    for loss in wanted:
        with simulated(arguments.place, arguments.p5 or UNHURRIED_MS) as (client, folder):
            stops += losstest.measure(client, cell, folder, loss, arguments.speed / 100.0)
    _report_stops(cell, stops, arguments, "emulator")
    if not arguments.json:
        print("last_stop_test is not written: these were emulated drives; on the machine: axisgate drive loss-test CELL --running")
    return DONE if all(stop.good for stop in stops) else FINDING


def _report_stops(cell: Cell, stops: "list[Stop]", arguments: argparse.Namespace, evidence: str) -> None:
    from gateway.tools.drives import loss_test as losstest

    written = losstest.write(cell, stops, arguments.out, evidence)
    if arguments.json:
        print(json.dumps(losstest.report(cell, stops, evidence)))
        return
    for stop in stops:
        verdict = "" if stop.good else "  DOES NOT STOP AS REQUIRED"
        print(
            f"{stop.loss:<10} {stop.axis:<6} {stop.speed:>9.1f} {stop.unit}/s  reacts after {stop.reaction_ms:>6.1f} ms "
            f"(allowed {stop.allowed_ms:g}), at rest after {stop.stop_ms:>7.1f} ms and {stop.way:>8.3f} {stop.unit}{verdict}"
        )
    print(f"written: {written[0]}, {written[1]}  (evidence: {evidence})")


def _loss_test_running(cell: Cell, arguments: argparse.Namespace) -> int:
    from gateway.assembly.run import slug_of
    from gateway.cell_file import stop_test_date as stopdate
    from gateway.tools.drives import loss_test_on_bus as losstest_bus

    if arguments.lose not in (None, ["gateway"]):
        complain("drive loss-test --running", "the loss of the gateway only; the others: without --running")
        return USAGE
    losstest_bus.drives_of(cell)
    run = arguments.name or slug_of(cell)
    with running(run) as client:
        simulated_run = bool(client.ask("axes")["simulated"])
        if not simulated_run and not _agreed(cell, arguments.speed):
            return ENVIRONMENT
        urls = {bus.name: f"broker:{run}-{bus.name}" if simulated_run else bus.port for bus in cell.bus}
        stops = losstest_bus.measure(client, cell, urls, arguments.speed / 100.0)
    _report_stops(cell, stops, arguments, "emulator" if simulated_run else "bus")
    good = all(stop.good for stop in stops)
    if good and not simulated_run:
        try:
            line = stopdate.write(pathlib.Path(cell.file), datetime.date.today())
            print(f"{cell.file}:{line}: last_stop_test is of today", file=sys.stderr)
        except stopdate.NotWritten as error:
            complain("drive loss-test", f"last_stop_test is not written: {error}")
    return DONE if good else FINDING


def _agreed(cell: Cell, speed: float) -> bool:
    """The operator at the machine has read the announcement and agreed."""
    print(
        f"{BANNER}\nAll axes of {cell.cell.name} move over 80 % of their travel at {speed:g} %, then the gateway is ended.", file=sys.stderr
    )
    if not sys.stdin.isatty():
        complain("drive loss-test", "not agreed; start it at a terminal")
        return False
    return input(f'Type "{AGREED}": ').strip().upper() == AGREED
