"""Warnings and notes: nothing here is wrong, all of it decides something in the plant (users.md 3.4)."""

import math
import re
from collections.abc import Iterator

from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.axis_signals import SINGLE, single_inputs
from gateway.assembly.data_block_signals import place_of, signals_of
from gateway.checks.blocks import counts_of, split_unit
from gateway.checks.context import number
from gateway.checks.playable import not_playable
from gateway.pure.arbitration.command_block import AXES as TABLED
from gateway.pure.arbitration.command_block import MASKED
from gateway.pure.buses.load import judge
from gateway.pure.cell.cell import Axis, Cell, Db, Entry, Line, Notice
from gateway.pure.cell.simulated_ports import unused_ports
from gateway.pure.controllers.rho3.signals.drives import AXES as SIGNALLED
from gateway.pure.cycle.enabling_inputs import SIGNAL_AXES
from gateway.pure.image.addresses import DataWord, Direction, RcBit
from gateway.pure.image.names import Kind, lookup
from gateway.pure.lines.line_profiles import link_profile
from gateway.pure.reports.transfer_times import cycle_us, job_ms, sdo_us, silence_s
from gateway.registry import BUS_PROTOCOLS, DRIVE_FAMILIES, LINE_LAYERS
from motion.geometry.units import from_si, to_si
from protocols.p3964r.profiles import NETWORK

EVERY = re.compile(r"(?:every|alle) (\d+) ms")
MARGIN = 1.25  # turnaround of both stations and doubled DLE on top of the bare characters
COUNTER = 2**31  # increments
CYCLE_FULL = 80.0  # %: above this a bus has no room for SDO, heartbeats and one blocking frame
ENABLING = {  # AX-002: bit -> our name, symbol
    24: ("emergency_stop_ok", "EMSTOP_OK_RCI"),
    25: ("control_allow", "CTRL_ALLOW_RCI"),
    26: ("feed_allow", "FEED_ALLOW_RCI"),
    27: ("feed_hold_not", "FEED_HOLD_N_RCI"),
    28: ("travel_allow", "TRAVEL_ALLOW_RCI"),
}


def tightest_range(cell: Cell) -> Iterator[Notice]:
    """The way, written as an integer, that uses most of its type's range."""
    axes = {axis.name: axis for axis in cell.axis}
    best: tuple[float, Notice] | None = None
    for block in cell.db:
        for entry in block.entries:
            found = lookup(entry.signal)
            if found and found.name.kind is Kind.WAY and found.which in axes:
                share = _share(block, entry, axes[found.which])
                if share and (best is None or share[0] > best[0]):
                    best = share
    if best:
        yield best[1]


def _share(block: Db, entry: Entry, axis: Axis) -> tuple[float, Notice] | None:
    address = place_of(block, entry)
    counts = counts_of(entry, address) if isinstance(address, DataWord) else None
    if counts is None:
        return None
    largest = counts[1] * split_unit(entry.unit)[0]
    text = f"largest value {largest:.1f} {axis.unit}; axis {axis.name} goes to {axis.limits.max:.1f} {axis.unit}: fits"
    return axis.limits.max / largest, Notice("note", f"db {block.number}, {entry.at} ({entry.type}, {entry.unit})", text)


def line_silence(cell: Cell) -> Iterator[Notice]:
    """How late the link itself reports a dead partner, and the first detection."""
    for line in _command_lines(cell):
        late, watch = silence_s(line), line.supervision
        qvz, attempts = late[0], late[1]
        by = (
            "by life word: good; also wire feed hold" if watch.life_word else "by silence only: give the PLC a life_word and wire feed hold"
        )
        text = (
            f"profile QVZ {qvz:g} ms x {attempts} attempts = {number(qvz * attempts / 1000)} s; "
            f"on_loss acts after {watch.max_silence_ms / 1000:.1f} s {by}"
        )
        yield Notice("note" if line.port == "sim" else "warning", f"line {line.name}", text)


def network(cell: Cell) -> Iterator[Notice]:
    """3964R through a serial server: its times hold only with room for the network, and packets must not be cut at a character (AX-224)."""
    for line in cell.line:
        if not line.port.startswith(("tcp://", "rfc2217://")):
            continue
        profile = link_profile(line)
        advice = "server: raw mode, packing at once or by a gap of 2..10 ms, no delimiter character (every value occurs in a block)"
        if line.profile.endswith(NETWORK):
            yield Notice(
                "note",
                f"line {line.name}",
                f"behind a network: QVZ {profile.ack_delay / 1e6:g} ms, ZVZ {profile.char_delay / 1e6:g} ms; {advice}",
            )
            continue
        times = f"ZVZ {profile.char_delay / 1e6:g} ms tolerates one stall of 200 ms"
        yield Notice(
            "warning", f"line {line.name}", f'{times} and no second one: profile = "{line.profile}{NETWORK}" adds 500 ms; {advice}'
        )


def bus_load(cell: Cell) -> Iterator[Notice]:
    """Worst-case load of every drive bus."""
    from gateway.assembly.bus_frames import bitrate, traffic  # they read their figures from this package

    for bus in cell.bus:
        if not any(axis.drive.bus == bus.name for axis in cell.axis):
            continue
        cycle, grid = cycle_us(cell, bus), 1000.0 * bus.cycle_ms
        load = 100.0 * cycle / grid
        extra = f"; + 1 SDO pair {100.0 * (cycle + sdo_us(bus)) / grid:.0f} %" if BUS_PROTOCOLS[bus.protocol].nodes else ""
        nodes = sorted({io.device.node for io in cell.io if io.device.bus == bus.name and io.device.node is not None})
        extra += "".join(f"; node {node} I/O event-driven" for node in nodes)
        text = f"{cycle:.0f} us of {grid:.0f} us worst case ({load:.0f} %){extra}"
        whole = 100.0 * judge(traffic(cell, bus), bitrate(bus), bus.cycle_ms).cycle.worst / grid
        full = max(load, whole) > CYCLE_FULL
        more = f": too full, choose a cycle of {math.ceil(max(cycle, whole * grid / 100.0) / 10.0 / CYCLE_FULL)} ms or more" if full else ""
        yield Notice("warning" if full else "note", f"bus {bus.name}", text + more)


def bus_whole(cell: Cell) -> Iterator[Notice]:
    """Load missing in `bus_load`: that counts only SYNC, set and actual values, as in the users' chapter."""
    from gateway.assembly.bus_frames import bitrate, traffic  # they read their figures from this package

    for bus in cell.bus:
        if not any(axis.drive.bus == bus.name for axis in cell.axis):
            continue
        grid = 1000.0 * bus.cycle_ms
        whole = 100.0 * judge(traffic(cell, bus), bitrate(bus), bus.cycle_ms).cycle.worst / grid
        if round(whole) != round(100.0 * cycle_us(cell, bus) / grid):
            yield Notice("note", f"bus {bus.name}", f"{whole:.0f} % with second TPDOs, heartbeats and I/O; each frame: axisgate bus load")


def polling(cell: Cell) -> Iterator[Notice]:
    """Duration of SEND and FETCH of the declared blocks, against the interval in the comments."""
    for line in _command_lines(cell):
        blocks = [block for block in cell.db if block.line == line.name and not _optional(cell, block)]
        jobs = [(_job_of(block), block.words, job_ms(line, block.words)) for block in blocks]
        if not jobs:
            continue
        total = sum(job[2] for job in jobs)
        listed = " + ".join(f"{job} {words} words {took:.0f} ms" for job, words, took in jobs)
        expect = f"expect {_tens(total):.0f}..{_tens(MARGIN * total):.0f} ms"
        wanted = min((int(found[1]) for block in blocks if (found := EVERY.search(block.comment))), default=None)
        if wanted is not None and wanted < total:
            text = f"{listed} at {line.baud} Bd: your {wanted} ms polling is not reachable; {expect}"
            yield Notice("warning", f"line {line.name}", text)
        else:
            yield Notice("note", f"line {line.name}", f"{listed} at {line.baud} Bd: {expect} for one round")
        if line.supervision.max_silence_ms < 3 * MARGIN * total:
            rounds = f"three rounds of {_tens(MARGIN * total):.0f} ms"
            text = f"max_silence_ms = {line.supervision.max_silence_ms} is less than {rounds}: one repeat stops the axes"
            yield Notice("warning", f"line {line.name}", text)


def _job_of(block: Db) -> str:
    """Job of a block: the partner sends what it writes and fetches the rest; our own jobs go the other way."""
    return "SEND" if (block.writer == "plc") is not bool(block.every_ms or block.on_change) else "FETCH"


def _optional(cell: Cell, block: Db) -> bool:
    """A block that repeats targets of another one is sent now and then, not polled."""
    others = {entry.to for other in cell.db if other is not block for entry in other.entries if entry.to}
    return block.writer == "plc" and all(entry.to in others for entry in block.entries)


def evidence(cell: Cell) -> Iterator[Notice]:
    """A SERVODYN bus on metal is not enabled on our own layout without evidence (design.md 5, AX-001)."""
    for bus in cell.bus:
        if BUS_PROTOCOLS[bus.protocol].boosted and not bus.simulated and not bus.layout_evidence:
            text = "no layout_evidence: listen-only, `run` sends nothing on it; record a running cell of the same type and name the file"
            yield Notice("warning", f"bus {bus.name}", text)
        elif BUS_PROTOCOLS[bus.protocol].boosted and not bus.simulated:
            text = f"layout {bus.layout} is axisgate's own (AX-001), not verified on hardware; evidence: {bus.layout_evidence}"
            yield Notice("note", f"bus {bus.name}", text)


def lag(cell: Cell) -> Iterator[Notice]:
    """Lag limits against the lag of the drive's position loop, if the plant gives Kv."""
    without = [axis.name for axis in cell.axis if axis.following_error is None]
    if without:
        yield Notice("note", f"axis {', '.join(without)}", "no following_error: only the drive supervises the lag")
    for axis in cell.axis:
        values = cell.plant.axis.get(axis.name) if cell.plant else None
        kv = values.settings.get("kv_per_s") if values else None
        if kv and axis.following_error and axis.following_error.warn < axis.limits.speed / kv:
            needed = f"speed / Kv = {number(axis.limits.speed / kv)} {axis.unit}"
            text = f"lag at full speed is {needed}; following_error.warn = {number(axis.following_error.warn)}"
            yield Notice("warning", f"axis {axis.name}", text)


def enabling(cell: Cell) -> Iterator[Notice]:
    """Enabling inputs without a writer read 0 (AX-002); assumed ones are reported every time."""
    if cell.rc_inputs.assume:
        yield Notice("warning", "rc_inputs", f"assumed as 1, not wired here: {', '.join(cell.rc_inputs.assume)}")
    written = {entry.to for block in cell.db for entry in block.entries} | {io.signal for io in cell.io} | set(cell.rc_inputs.assume)
    written |= {route.to for route in cell.route}
    missing = [
        name
        for bit, (name, symbol) in ENABLING.items()
        if bit // 8 not in cell.rc_inputs.owner and f"cell.{name}" not in written and symbol not in written
    ]
    if missing and not not_playable(cell):
        text = f"{', '.join(missing)} have no writer: they read 0 and nothing will move; name an owner of byte 3 or assume them"
        yield Notice("warning", "rc_inputs", text)


def feed_of_kinematics(cell: Cell) -> Iterator[Notice]:
    """Feed inputs of single kinematics: without a writer they read 0, without `wired` they are not read (AX-1787)."""
    signals = signals_of(cell)
    named = {text for text in _written(cell) if (signal := signals.named(text)) is not None and SINGLE.fullmatch(signal.name)}
    wired = {signal.name for name in cell.rc_inputs.wired if (signal := signals.named(name)) is not None}
    written = {signal.name for text in named if (signal := signals.named(text)) is not None}
    if unread := sorted(written - wired):
        yield Notice("warning", "rc_inputs", f"{', '.join(unread)} written and not read: name them in [rc_inputs] wired")
    for kinematic, _, place in single_inputs(cell) if not not_playable(cell) else ():
        signal = signals.at(RcBit(Direction.INPUT, place))
        if signal is not None and place // 8 not in cell.rc_inputs.owner and signal.name not in written:
            yield Notice("warning", "rc_inputs", f"{signal.name} has no writer: it reads 0 and kinematic {kinematic} will not move")


def _written(cell: Cell) -> set[str]:
    """Names written by entries of data blocks, contacts and routes."""
    written = {entry.to for block in cell.db for entry in block.entries if entry.to} | {
        io.signal for io in cell.io if io.device.input is not None
    }
    return written | {route.to for route in cell.route}


def counting(cell: Cell) -> Iterator[Notice]:
    """Endless axes go round, the 32 bits of their drives' set values do not (AX-568)."""
    for axis in cell.axis:
        if axis.modulo:
            rounds = COUNTER / abs(scaling_of(axis).inc_per_unit * to_si(axis.modulo, axis.unit))
            text = f"endless; its set values have 32 bits: about {rounds:.0f} turns in either direction from the drive's zero"
            yield Notice("note", f"axis.{axis.name}", f"{text}, then the drives go off with reason SET_VALUE")
            if axis.home.by == "none":
                text = (
                    "endless and absolute: an encoder that overflows while the gateway is off looks as if the axis had been "
                    "turned; at the start the gateway reports where this may be the case (AX-607)"
                )
                yield Notice("note", f"axis.{axis.name}.home", text)


def resolvers(cell: Cell) -> Iterator[Notice]:
    """A booster's resolver counts from 0 to the end of one motor turn when its power returns (AX-085)."""
    real = {bus.name for bus in cell.bus if not bus.simulated}
    for axis in cell.axis:
        if axis.home.by != "none" or axis.drive.bus not in real or not DRIVE_FAMILIES[axis.drive.type].boosted:
            continue
        turn = from_si(axis.drive.inc_per_turn / abs(scaling_of(axis).inc_per_unit), axis.unit)
        if axis.limits.max - axis.limits.min > turn:
            words = (
                f"absolute only within one motor turn, {turn:.4g} {axis.unit}: after the booster has been switched off, the axis may be "
                "shown wrong by whole turns (AX-085)"
            )
            yield Notice("warning", f"axis.{axis.name}.home", f'{words}; reference it: home = {{ by = "gateway", .. }}')


def serials(cell: Cell) -> Iterator[Notice]:
    """A drive without a serial number reports 0: every such drive would be the pinned one."""
    for axis in cell.axis:
        text = axis.drive.serial
        if DRIVE_FAMILIES[axis.drive.type].objects and text[:1].isdigit() and int(text, 0) == 0:
            words = f"serial {text!r} does not identify a drive: 1018h:04 is 0 in a drive without one; vendor and product are compared"
            yield Notice("warning", f"axis.{axis.name}.drive.serial", words)


def many_axes(cell: Cell) -> Iterator[Notice]:
    """Limits of old tables in a cell with more axes than the old controller had (AX-572)."""
    names = [axis.name for axis in cell.axis]
    if len(names) <= TABLED:
        return
    served = {block.line for block in cell.db}
    sources = [f"modbus {source.name}" for source in cell.modbus if source.command_block]
    sources += [f"line {line.name}" for line in cell.line if LINE_LAYERS[line.layer].blocks and line.name not in served]
    behind = f"; bits 0..14 of its masks are axes 1..15, bit 15 is {names[MASKED]} and all after it" if len(names) > MASKED else ""
    for source in sources:
        own = f"its command block has targets and positions up to axis {TABLED} ({names[TABLED - 1]}) only"
        yield Notice("note", source, f"{own}{behind}; programs move all (AX-572)")
    if cell.controller is not None:
        text = f"INPOS and referenced: axes 1..{SIGNAL_AXES}; axes after {SIGNALLED} have no drive-on and no disable signal of their own"
        yield Notice("note", "controller", f"{text} (AX-572)")


def simulated(cell: Cell) -> Iterator[Notice]:
    """Ports that are in the file and stay closed."""
    if words := unused_ports(cell):
        yield Notice("warning", "cell", f'{words}; to use them: target = "machine"')


def unplayed(cell: Cell) -> Iterator[Notice]:
    """Parts that this version checks but cannot run."""
    reasons = not_playable(cell)
    if reasons:
        yield Notice("note", "run", f"not playable yet: {', '.join(reasons)}")


def _command_lines(cell: Cell) -> list[Line]:
    served = {block.line for block in cell.db}
    return [line for line in cell.line if LINE_LAYERS[line.layer].blocks and line.name in served]


def _tens(value: float) -> float:
    return 10.0 * math.ceil(value / 10.0)


NOTES = (
    tightest_range,
    line_silence,
    network,
    bus_load,
    polling,
    evidence,
    lag,
    enabling,
    feed_of_kinematics,
    bus_whole,
    counting,
    resolvers,
    serials,
    many_axes,
    simulated,
    unplayed,
)
