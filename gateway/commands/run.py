"""Run a cell: drives on the bus, PLCs on their lines (--sim: all simulated; --shadow: listen next to the old controller)."""

import argparse
import errno
import json
import os
import pathlib
import socket
import sys

from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from gateway.assembly.drive_buses import DRIVE_PROTOCOLS, LISTENS
from gateway.assembly.run import Instead, RunPlan, plan_run
from gateway.checks.playable import not_playable
from gateway.commands import shadow_run as shadow
from gateway.links.canopen.listen_first import refuse_on
from gateway.processes.child_start import ONE_THREAD
from gateway.processes.supervisor import Supervisor
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.simulated_ports import unused_ports
from gateway.pure.cell.web import Web
from gateway.runtime.console import fill_standard, say_at_start
from gateway.runtime.realtime import die_with_parent, realtime_allowed
from gateway.runtime.state_folder import usable, warning
from gateway.tools.cell_argument import load_apart
from gateway.tools.command_support import BANNER, DONE, ENVIRONMENT, USAGE
from gateway.tools.drives.first_enable import TEXT, confirm, needed
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate run demo --sim                       the demo's cell, everything simulated
  axisgate run cell.toml --sim --web 8480       your cell without hardware, with its page on http://127.0.0.1:8480
  axisgate run cell.toml                        your cell on its real ports
  axisgate run cell.toml --shadow --tap plc=/dev/ttyUSB0,/dev/ttyUSB1 --bus socketcan:can0
  axisgate run cell.toml --shadow --tap plc2=/run/user/1000/plc2.pcap,10.0.0.7:502 --bus socketcan:can0 --tolerance 0.5
                                                next to the working old controller: nothing is sent, its status is compared with axisgate's
"""
SLOW_P5 = 10  # ms, as the demo: the clock of a simulation without real-time priority
STRETCHED = "real-time priority is refused here: P5 = {p5} ms, and simulated time waits where this machine is late (axisgate doctor)"


def main(argv: list[str]) -> int:
    fill_standard()
    parser = argparse.ArgumentParser(
        prog="axisgate run", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", help="cell file, or the name of a shipped one")
    parser.add_argument("--sim", action="store_true", help="simulate drives, bus and serial lines")
    parser.add_argument("--bus", help="CAN port instead of the one in the cell, e.g. socketcan:vcan0")
    parser.add_argument("--p5", type=int, help="cycle in ms (2..32) instead of the one in the cell")
    parser.add_argument("--modbus-port", type=int, help="TCP port in place of the cell's")
    parser.add_argument("--web", type=int, metavar="PORT", help="serve the page on this TCP port (default: [web] of the cell)")
    parser.add_argument("--name", help="name of this run for `axisgate var` (default: the file's)")
    parser.add_argument("--record", type=pathlib.Path, help="folder for bus log, line and emulator records")
    parser.add_argument("--json", action="store_true", help="print the plan of the run as JSON and do not start it")
    parser.add_argument("--die-with-parent", action="store_true", help=argparse.SUPPRESS)  # for tests: no run outlives its starter
    shadow.add_options(parser)
    arguments = parser.parse_args(argv)
    if words := shadow.misplaced(arguments):
        parser.error(words)
    if arguments.die_with_parent:
        die_with_parent()
    os.environ.update(ONE_THREAD)  # before a module of the run loads numpy: only a process of one thread is copied (AX-1740)
    cell = load_apart(arguments.cell)
    if isinstance(cell, int):
        return cell
    if arguments.shadow:
        return _listening(arguments, cell)
    refusal = why_not(cell, p5=arguments.p5)
    if refusal:
        complain("run", refusal)
        return USAGE if refusal.startswith("--p5") else ENVIRONMENT
    axes = needed(cell, simulated=arguments.sim)
    if axes and not arguments.json:
        if not sys.stdin.isatty():
            print(f"{TEXT}\naxisgate run: not confirmed for {', '.join(axes)}; start it once at a terminal", file=sys.stderr)
            return ENVIRONMENT
        if not confirm(cell, axes, input, print):
            return ENVIRONMENT
    return _start(arguments, cell)


def _start(arguments: argparse.Namespace, cell: Cell) -> int:
    """Report faults of ports before anything runs."""
    simulated = arguments.sim or cell.cell.target == "simulation"
    clock_ms, stretched = clock_of(cell, arguments, simulated=simulated)
    if arguments.record:
        arguments.record.mkdir(parents=True, exist_ok=True)
    try:
        usable()
        plan = plan_run(
            cell,
            simulated=simulated,
            slug=arguments.name,
            record=arguments.record,
            instead=Instead(arguments.bus, clock_ms, arguments.modbus_port, arguments.web),
            stretched=stretched,
        )
        if arguments.json:
            print(json.dumps(describe(plan), indent=1))
            return DONE
        if plan.web is not None:
            page_port_free(plan.web)
        if plan.simulated and arguments.bus is not None and plan.buses:
            open_can(arguments.bus).close()  # PortError now: simulated drives would try a missing bus again and again, and the run wait
        _look_first(cell, arguments.bus, simulated=plan.simulated and arguments.bus is None)
        say_at_start(BANNER)
        if words := warning(cell.file, simulated=plan.simulated):
            say_at_start(words)
        if stretched and clock_ms is not None:
            say_at_start(STRETCHED.format(p5=plan.p5_ms))
        if not arguments.sim and (words := unused_ports(cell, bus=arguments.bus is None)):
            say_at_start(words)
        for name in plan.listening:
            say_at_start(f"bus {name} {LISTENS}; next: axisgate bus log {plan.buses[name]} -o living.log, then axisgate bus infer")
        if plan.web is not None:
            say_at_start(f"page: {'https' if plan.web.tls_certificate else 'http'}://{plan.web.bind}/")
        return Supervisor(plan).run()
    except PortError as error:
        complain("run", error)
        return ENVIRONMENT


def page_port_free(web: Web) -> None:
    """PortError when another program has it: a browser would show that one's page, perhaps another cell's."""
    host, _, port = web.bind.rpartition(":")
    host = host.strip("[]")
    try:
        with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server does: a port that only waits is free
            probe.bind((host, int(port)))
            probe.listen(1)
    except (OSError, OverflowError) as error:
        if isinstance(error, OSError) and error.errno == errno.EADDRNOTAVAIL:
            say_at_start(f"page: no interface of this machine has the address of {web.bind} yet; the page starts when it has")
            return
        taken = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
        words = "is in use by another program or run" if taken else f"cannot be used ({error})"
        raise PortError(f"the page's port {web.bind} {words}; choose another one: --web PORT, or port in [web]") from error


def _listening(arguments: argparse.Namespace, cell: Cell) -> int:
    if words := why_not(cell, p5=arguments.p5):
        complain("run", words)
        return USAGE if words.startswith("--p5") else ENVIRONMENT
    try:
        return shadow.run_shadow(arguments, cell)
    except PortError as error:
        complain("run", error)
        return ENVIRONMENT


def _look_first(cell: Cell, bus: str | None, *, simulated: bool) -> None:
    """Raises PortError if another master is active on a drive bus; a missing port is checked when it appears."""
    for each in cell.bus:
        if each.protocol in DRIVE_PROTOCOLS and not simulated and (bus or each.port != "sim"):
            refuse_on(bus or each.port, each.protocol)


def clock_of(cell: Cell, arguments: argparse.Namespace, *, simulated: bool) -> tuple[int | None, bool]:
    """The clock, None: the cell's own; and whether simulated time waits for this computer (AX-681, AX-915).  --p5 and --bus
    are honoured.
    """
    if not simulated or arguments.p5 is not None or arguments.bus is not None:
        return arguments.p5, False
    return None if realtime_allowed() else max(cell.cycle_ms, SLOW_P5), True


def why_not(cell: Cell, *, p5: int | None) -> str:
    """Empty, or why this cell cannot be played here."""
    if p5 is not None and not 2 <= p5 <= 32:
        return f"--p5 {p5}: the cycle is 2..32 ms (drives on CAN, rho3 P5)"
    missing = not_playable(cell)
    if missing:
        return "this version cannot run: " + "; ".join(missing)
    if not cell.axis:
        return "the cell has no [[axis]]: nothing to run"
    return ""


def describe(plan: RunPlan) -> dict[str, object]:
    """Describe the run, for scripts."""
    return {
        "name": plan.slug,
        "p5_ms": plan.p5_ms,
        "stretched": plan.stretched,
        "buses": dict(plan.buses),
        "listening": list(plan.listening),
        "lines": dict(plan.lines),
        "web": plan.web.bind if plan.web else None,
        "modbus": {name: plan.modbus_place(name) for name in plan.modbus},
        "command_sources": [{"number": source.number, "name": source.name, "kind": source.kind} for source in plan.sources],
        "processes": [{"name": child.name, "module": child.module, "arguments": list(child.arguments)} for child in plan.children],
    }
