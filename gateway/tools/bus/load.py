"""axisgate bus load: does a cell fit its cycle; what did a recorded bus carry, exact to the bit."""

import argparse
import json
import pathlib
from collections.abc import Iterable, Sequence

from drivers.ports.can.wire import RTR_FLAG
from gateway.assembly.bus_frames import bitrate, traffic
from gateway.pure.buses.load import Judgement, Times, Traffic, judge, times
from gateway.pure.cell.cell import Bus, Cell
from gateway.tools.bus.logs import READABLE, BadLog, read_log
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, FINDING, USAGE, of_file
from gateway.tools.usage_language import complain
from protocols.base.can_bits import frame_bits
from protocols.base.machine import Frame, Ns

EXAMPLES = """examples:
  axisgate bus load demo.toml                   every bus of the cell: us of the cycle and per cent, before running
  axisgate bus load s5-rk512.toml --json
  axisgate bus load --log bus-drives.log --bitrate 1000000     frames that were there, stuff bits counted one by one
exit code: 0 fits, 1 does not, 2 command line or file"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bus load", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", nargs="?", help="cell file")
    parser.add_argument("--log", type=pathlib.Path, help="a recording (candump, ASC, BLF, TRC) in place of a cell")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="of the recording, bit/s (default %(default)s)")
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")
    arguments = parser.parse_args(argv)
    if (arguments.cell is None) == (arguments.log is None):
        complain("bus load", "name either a cell or --log FILE")
        return USAGE
    if arguments.log is not None:
        return _of_log(arguments)
    if pathlib.Path(arguments.cell).suffix in READABLE:
        complain("bus load", f"{arguments.cell} is a recording: --log {arguments.cell}")
        return USAGE
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    return _of_cell(cell, as_json=arguments.json)


def _of_cell(cell: Cell, *, as_json: bool) -> int:
    plans = [(bus, traffic(cell, bus)) for bus in cell.bus]
    judged = [(bus, plan, judge(plan, bitrate(bus), bus.cycle_ms)) for bus, plan in plans if plan]
    if as_json:
        print(json.dumps([_record(*one) for one in judged], indent=1))
    else:
        print("\n\n".join(_table(*one) for one in judged) or "no bus with frames of its own in this cell")
    return DONE if all(one[2].fits for one in judged) else FINDING


def _record(bus: Bus, plan: Sequence[Traffic], verdict: Judgement) -> dict[str, object]:
    return {
        "bus": bus.name,
        "bitrate": bitrate(bus),
        "cycle_ms": bus.cycle_ms,
        "frames": [
            {"what": one.what, "id": one.identifier, "bytes": one.length, "every_ms": one.every_ms, "acyclic": one.acyclic, **_us(one, bus)}
            for one in plan
        ],
        "cycle_us": _named(verdict.cycle),
        "acyclic_us": _named(verdict.acyclic),
        "sync_blocked_us": verdict.sync_blocked,
        "shortest_cycle_ms": verdict.shortest_ms,
        "fits": verdict.fits,
    }


def _us(one: Traffic, bus: Bus) -> dict[str, object]:
    return {"us": _named(times(one, bitrate(bus)))}


def _named(value: Times) -> dict[str, float]:
    return {"plain": round(value.plain, 1), "typical": round(value.typical, 1), "worst": round(value.worst, 1)}


def _table(bus: Bus, plan: Sequence[Traffic], verdict: Judgement) -> str:
    lines = [f"bus {bus.name}: {bus.protocol}, {bus.bitrate}, cycle {bus.cycle_ms} ms"]
    lines.append(f"  {'frame':22}{'identifier':>13}{'bytes':>7}  {'when':12}{'plain':>7}{'typical':>9}{'worst us':>10}")
    for one in plan:
        when = "one a cycle" if one.acyclic else f"each {one.every_ms:g} ms" if one.every_ms else "each cycle"
        us = times(one, bitrate(bus))
        named = f"{one.identifier} ({one.identifier:X}h)"
        lines.append(f"  {one.what:22}{named:>13}{one.length:>7}  {when:12}{us.plain:7.0f}{us.typical:9.1f}{us.worst:10.0f}")
    share = 0.1 / bus.cycle_ms
    cycle, more = verdict.cycle, verdict.cycle + verdict.acyclic
    range_us = f"{cycle.plain:.0f} .. {cycle.typical:.0f} .. {cycle.worst:.0f} us of {1000 * bus.cycle_ms} us"
    lines.append(f"  cycle {range_us}: worst {cycle.worst * share:.0f} %")
    if verdict.acyclic.worst:
        lines.append(f"  with one SDO pair a cycle: worst {more.worst:.0f} us, {more.worst * share:.0f} %")
    lines.append(f"  SYNC may wait {verdict.sync_blocked:.0f} us for a frame that has just begun")
    lines.append(f"  shortest cycle for all of it: {verdict.shortest_ms} ms")
    word = "fits" if verdict.fits else f"does not fit: choose cycle_ms = {verdict.shortest_ms} or more, or a second bus"
    return "\n".join([*lines, f"  {word}"])


def _of_log(arguments: argparse.Namespace) -> int:
    try:
        total = measured(read_log(arguments.log), arguments.bitrate)
    except (OSError, BadLog) as error:
        complain("bus load", of_file(error))
        return USAGE
    if arguments.json:
        print(json.dumps(total, indent=1))
    else:
        print(
            f"{total['frames']} frames, {total['bits']} bits ({total['stuffed']} stuff bits) in {total['seconds']:.3f} s: "
            f"load {total['load_percent']:.2f} %, busiest 10 ms {total['busiest_percent']:.1f} %"
        )
    return DONE


def measured(frames: Iterable[Frame], rate: int, window: Ns = 10_000_000) -> dict[str, float]:
    """Exact bits of recorded frames; `busiest`: the fullest window of 10 ms, by stamps."""
    bits = count = plain = 0
    first = last = 0
    windows: dict[int, int] = {}
    for frame in frames:
        data = b"" if frame.identifier & RTR_FLAG else frame.data
        length = frame_bits(frame.identifier & 0x1FFFFFFF, data, extended=bool(frame.identifier >> 31))
        bits, count = bits + length, count + 1
        plain += length - (67 if frame.identifier >> 31 else 47) - 8 * len(data)
        first, last = first or frame.stamp_ns, frame.stamp_ns
        windows[frame.stamp_ns // window] = windows.get(frame.stamp_ns // window, 0) + length
    seconds = (last - first) / 1e9
    return {
        "frames": count,
        "bits": bits,
        "stuffed": plain,
        "seconds": seconds,
        "load_percent": 100.0 * bits / rate / seconds if seconds else 0.0,
        "busiest_percent": 100.0 * max(windows.values(), default=0) / (rate * window / 1e9),
    }
