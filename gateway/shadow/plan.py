"""Plan of a shadow: cycle and services of the cell on ports that only listen, nothing else (AX-493)."""

import ipaddress
from collections.abc import Mapping, Sequence
from dataclasses import replace

from gateway.assembly.axis_signals import ASSUMED, INPUT_SIGNALS, rc_numbers
from gateway.assembly.run import Instead, RunPlan, plan_run, slug_of
from gateway.pure.cell.axes import FollowingError
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.modbus import Modbus
from gateway.registry import LINE_LAYERS

LINES, BUSES = "shadow-lines.json", "shadow-buses.json"  # findings of services and cycle, in the folder of the run
SPOKEN = ("servodyn", "rho3-io", "canopen")
ENDLESS = FollowingError(float("inf"), float("inf"))
LIFE_NS = 10_000_000_000  # nothing depends on it, and a successor would have lost the findings
Taps = Mapping[str, tuple[str, str]]  # line -> ports that listen to the PLC and to the old controller; server -> capture, address


def why_not_shadow(cell: Cell, taps: Taps, bus: str | None) -> str:
    """Empty, or why this cell has no shadow."""
    if not cell.axis:
        return "the cell has no [[axis]]: nothing to compare"
    listened = [each for each in cell.bus if each.protocol in SPOKEN]
    if bus is not None and len(listened) > 1:
        return f"--bus names one bus, the cell has {', '.join(each.name for each in listened)}: set their ports in the cell"
    if bus is None and any(each.port == "sim" for each in listened):
        return f"bus {listened[0].name} has port sim; name the bus of the old controller, e.g. --bus socketcan:can0"
    return _why_no_tap(cell, taps)


def _why_no_tap(cell: Cell, taps: Taps) -> str:
    lines, servers = {line.name: line for line in cell.line}, {each.name: each for each in cell.modbus if each.role == "server"}
    if not taps:
        if servers and not lines:
            return f"no --tap: name a capture of its Modbus, e.g. --tap {next(iter(servers))}=/run/plc.pcap,10.0.0.7:502"
        return f"no --tap: name two receive-only ports, e.g. --tap {next(iter(lines), 'LINE')}=FROM_PLC,FROM_CONTROLLER"
    for name, (_, second) in taps.items():
        if name in servers:
            if words := _why_no_capture(servers[name], second):
                return words
            continue
        line = lines.get(name)
        if line is None:
            known = f"the cell's lines are {', '.join(lines) or 'none'}"
            return f"--tap {name}: {known}" + (f", its Modbus servers {', '.join(servers)}" if servers else "")
        if not LINE_LAYERS[line.layer].shadowed or line.protocol not in ("3964R", "3964"):
            return f"--tap {name}: layer {line.layer} on {line.protocol}; a shadow understands rk512 on 3964R"
    return ""


def _why_no_capture(server: Modbus, address: str) -> str:
    if server.tls is not None or server.serial or server.framing == "rtu":
        return f"--tap {server.name}: Modbus TCP without TLS can be captured, nothing else of Modbus"
    host, colon, port = address.rpartition(":")
    try:
        ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        colon = ""
    if not colon or not port.isdecimal():
        return f"--tap {server.name}=..,{address}: the old controller's address and port expected, e.g. 10.0.0.7:502"
    return ""


def left_out(cell: Cell, taps: Taps) -> list[str]:
    """Parts of the cell that the shadow neither receives nor compares, in words."""
    found = [f"line {line.name}: not tapped" for line in cell.line if line.name not in taps]
    found += [f"modbus {modbus.name}: neither served nor written" for modbus in cell.modbus if modbus.name not in taps]
    found += [f"contact {io.name}: neither read nor switched" for io in cell.io]
    found += ["routes: they need contacts or Modbus" for _ in cell.route[:1] if _unjoined(cell, taps)]
    found += [f"bus {bus.name}: only what was sent is known of {bus.protocol}" for bus in cell.bus if bus.protocol not in SPOKEN]
    if unheard := _unheard(cell, taps):
        found.append(f"enabling inputs that no tap supplies, assumed 1: {', '.join(unheard)}")
    return found


def shadow_cell(cell: Cell, taps: Taps) -> Cell:
    """The cell for shadow mode: writes to no partner, keeps nothing, judges no lag; inputs without a tap count as 1."""
    owner = {octet: source for octet, source in cell.rc_inputs.owner.items() if source in taps}
    return replace(
        cell,
        rc_inputs=replace(cell.rc_inputs, owner=owner, assume=(*cell.rc_inputs.assume, *_unheard(cell, taps))),
        line=tuple(line for line in cell.line if line.name in taps),
        db=tuple(db for db in cell.db if db.line in taps),
        axis=tuple(replace(axis, following_error=ENDLESS) for axis in cell.axis),
        bus=tuple(bus for bus in cell.bus if bus.protocol in SPOKEN),
        route=() if _unjoined(cell, taps) else cell.route,
        telegram=(),
        modbus=tuple(modbus for modbus in cell.modbus if modbus.name in taps),
        io=(),
        retain=None,
        web=None,
        northbound=None,
    )


def _unjoined(cell: Cell, taps: Taps) -> bool:
    """Routes may need parts that a shadow lacks."""
    return bool(cell.io) or any(modbus.name not in taps for modbus in cell.modbus)


def _unheard(cell: Cell, taps: Taps) -> list[str]:
    """Enabling inputs the cell does not assume itself, and whose byte no tapped line writes."""
    numbers = rc_numbers(cell)
    assumed = {INPUT_SIGNALS.get(name.upper(), name.lower()) for name in cell.rc_inputs.assume}
    heard = {octet for octet, source in cell.rc_inputs.owner.items() if source in taps}
    return [name for name in ASSUMED if name not in assumed and getattr(numbers, name) >> 3 not in heard]


def plan_shadow(cell: Cell, taps: Taps, *, slug: str | None, bus: str | None, p5_ms: int | None, tolerance: float | None = None) -> RunPlan:
    """Of a cell that has one (why_not_shadow).  It counts as simulated: nothing is kept for the next run.  `tolerance` of positions,
    in the unit of each axis; None: the lag that each may have before it is warned of."""
    plan = plan_run(shadow_cell(cell, taps), simulated=False, slug=slug or f"{slug_of(cell)}-shadow"[:31], instead=Instead(bus, p5_ms))
    modules = {"cycle": "gateway.shadow.cycle", "services": "gateway.shadow.services"}
    children = [
        replace(child, module=modules.get(child.name, child.module), spare=False, life_limit_ns=max(child.life_limit_ns, LIFE_NS))
        for child in plan.children
        if child.name in (*modules, "planner")
    ]
    for left in (LINES, BUSES):
        (plan.folder / left).unlink(missing_ok=True)
    near = {
        axis.name: (axis.following_error.warn if axis.following_error else 0.0) if tolerance is None else tolerance for axis in cell.axis
    }
    return replace(plan, children=tuple(children), simulated=True, taps=dict(taps), tolerances=near)


def parse_taps(words: Sequence[str]) -> Taps:
    """LINE=FROM_PLC,FROM_CONTROLLER each; ValueError."""
    taps = {}
    for word in words:
        name, equals, ports = word.partition("=")
        from_plc, comma, from_control = ports.partition(",")
        if not (name and equals and from_plc and comma and from_control):
            raise ValueError(
                f"--tap {word}: LINE=FROM_PLC,FROM_CONTROLLER expected, e.g. plc=/dev/ttyUSB0,/dev/ttyUSB1; "
                "or SERVER=CAPTURE,OLD_CONTROLLER"
            )
        taps[name] = (from_plc, from_control)
    return taps
