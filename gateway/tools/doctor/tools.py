"""`axisgate doctor serial`, `doctor can` and `doctor --hour`: measured, and said for which clock it is good enough."""

import argparse
import json
from collections.abc import Callable, Sequence

from drivers.ports.base import PortError
from drivers.ports.can.adapter_url import is_adapter
from gateway.pure.cell.cell import Cell
from gateway.pure.reports.latency import CLOCKS_MS, Measured, verdict
from gateway.runtime.exit_codes import Exit
from gateway.tools.doctor.measure import NoEcho, can_echo, lateness, progress, serial_echo
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate doctor serial /dev/ttyUSB0               with a loop plug: how long the adapter keeps a character
  axisgate doctor can socketcan:can0 --send         until another listener of the channel receives a frame from axisgate
  axisgate doctor --hour cell.toml                  an hour of this machine, compared with the cycle of the cell
serial and --hour's lines need send and receive bridged at the adapter; nothing but single characters is sent.
exit code: 0 fast enough for that cycle, 1 not, 2 command line, 3 no such port, or no echo"""
EVERY_MS = CLOCKS_MS[-1]
SHARE = 0.25  # of its clock a cycle may begin late
COUNT, SECONDS = 1000, 10.0


def main(argv: list[str]) -> int:
    """serial | can."""
    arguments = make_parser().parse_args(argv)
    if not (1 <= arguments.count <= 1_000_000 and 0 < arguments.seconds <= 86_400):
        return _said("--count 1..1000000, --seconds up to 86400", Exit.INVALID)
    said = progress(f"echo of {arguments.port}")

    def echo() -> list[float]:
        if arguments.tool == "serial":
            return serial_echo(arguments.port, arguments.format, arguments.count, said)
        return can_echo(arguments.port, arguments.count, said)

    if arguments.tool == "can" and _real(arguments.port) and not arguments.send:
        words = "sends frames with identifier 7FFh on a real bus; switch the drives off first, then: axisgate doctor can "
        return _said(f"{words}{arguments.port} --send", Exit.INVALID)
    return _measure({"adapter echo": (echo, 1.0)}, arguments.seconds, arguments.clock, as_json=arguments.json)


def _real(url: str) -> bool:
    """Metal may hang on it."""
    return is_adapter(url) or (url.startswith("socketcan:") and "vcan" not in url)


def hour(cell: Cell, seconds: float, *, as_json: bool) -> int:
    """The machine for so long, against the clock of the cell."""
    return _measure({}, seconds, cell.cycle_ms, as_json=as_json)


def make_parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("axisgate doctor", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    tools = parser.add_subparsers(dest="tool", required=True, metavar="serial|can")
    for name, metavar, text in (
        ("serial", "PORT", "a serial adapter with a loop plug"),
        ("can", "CHANNEL", "a CAN adapter or the local bus"),
    ):
        tool = tools.add_parser(name, help=text, description=__doc__, epilog=EXAMPLES, formatter_class=raw)
        tool.add_argument("port", metavar=metavar)
        tool.add_argument("--count", type=int, default=COUNT, help="echoes (default %(default)s)")
        tool.add_argument("--seconds", type=float, default=SECONDS, help="of the machine's own lateness (default %(default)s)")
        tool.add_argument("--clock", type=int, choices=CLOCKS_MS, help="in ms: exit code 1 where it is not good for this one")
        tool.add_argument("--json", action="store_true", help="figures and verdict as one JSON object")
        if name == "serial":
            tool.add_argument("--format", default="115200 8N1", help="of the line (default %(default)s)")
        else:
            tool.add_argument("--send", action="store_true", help="also on a real bus: frames with identifier 7FFh")
    return parser


def _measure(echoes: dict[str, tuple[Callable[[], Sequence[float]], float]], seconds: float, clock: int | None, *, as_json: bool) -> int:
    try:
        measured = [Measured(what, sorted(times()), share) for what, (times, share) in echoes.items()]
        measured.append(Measured("scheduling of this machine", sorted(lateness(seconds, progress("scheduling"))), SHARE))
    except NoEcho as error:
        return _said(str(error), Exit.ENVIRONMENT)
    except PortError as error:
        return _said(f"{error.args[-1]}; next: axisgate doctor", Exit.ENVIRONMENT)
    except ValueError as error:
        return _said(str(error), Exit.INVALID)
    found = verdict(measured)
    if as_json:
        by_test = {each.what: {**each.figures(), "clock_ms": each.clock()} for each in measured}
        print(json.dumps({"good_for_ms": found.good, "verdict": found.words, "wanted_ms": clock, "figures": by_test}))
    else:
        for each in measured:
            figures = ", ".join(f"{name} {value:g}" for name, value in each.figures().items())
            print(f"{each.what}, ms: {figures}")
        print(found.words)
        if found.good is None or (clock is not None and found.good > clock):
            print("next: axisgate doctor     names latency timers, priorities and limits that can be improved")
    return Exit.OK if found.good is not None and found.good <= (clock or EVERY_MS) else Exit.FINDING


def _said(words: str, code: Exit) -> int:
    complain("doctor", words)
    return code
