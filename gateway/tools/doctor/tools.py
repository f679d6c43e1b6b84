"""Measure an adapter or this machine: percentiles, and the shortest cycle that they are good for."""

import argparse
import json
import os
from collections.abc import Callable, Sequence

from drivers.ports.base import PortError
from drivers.ports.can.adapter_url import is_adapter
from gateway.files.texts import spoken
from gateway.pure.cell.cell import Cell
from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.pure.reports.latency import CLOCKS_MS, Measured, verdict
from gateway.runtime.exit_codes import Exit
from gateway.tools.doctor.measure import NoEcho, can_echo, lateness, progress, serial_echo
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate doctor serial /dev/ttyUSB0               with a loop plug: how long the adapter keeps a character
  axisgate doctor can socketcan:can0 --send         how long a frame takes to another listener of the channel
  axisgate doctor --hour cell.toml                  an hour of this machine, compared with the cycle of the cell
doctor serial needs send and receive bridged at the adapter; it sends single characters only.
exit code: 0 fast enough for that cycle, 1 not, 2 command line, 3 no such port, or no echo"""
EVERY_MS = CLOCKS_MS[-1]
SHARE = 0.25  # of its clock a cycle may begin late
COUNT, SECONDS = 1000, 10.0
NEXT = "next: axisgate doctor     names latency timers, priorities and limits that can be improved"


def main(argv: list[str]) -> int:
    """Measure one adapter: serial or can."""
    arguments = make_parser().parse_args(argv)
    if not 1 <= arguments.count <= 1_000_000:
        return _said(f"--count {arguments.count}: 1..1000000 expected", Exit.INVALID)
    if not 0 < arguments.seconds <= 86_400:
        return _said(f"--seconds {arguments.seconds:g}: above 0, at most 86400 expected", Exit.INVALID)
    language = language_of(arguments.language, dict(os.environ))
    said = progress(_in(f"echo of {arguments.port}", language))

    def echo() -> list[float]:
        if arguments.tool == "serial":
            return serial_echo(arguments.port, arguments.format, arguments.count, said)
        return can_echo(arguments.port, arguments.count, said)

    if arguments.tool == "can" and _real(arguments.port) and not arguments.send:
        words = "sends frames with identifier 7FFh on a real bus; switch the drives off first, then: axisgate doctor can "
        return _said(f"{words}{arguments.port} --send", Exit.INVALID)
    return _measure({"adapter echo": (echo, 1.0)}, arguments.seconds, arguments.clock, language, as_json=arguments.json)


def _real(url: str) -> bool:
    """Real drives may be connected to it."""
    return is_adapter(url) or (url.startswith("socketcan:") and "vcan" not in url)


def hour(cell: Cell, seconds: float, language: str, *, as_json: bool) -> int:
    """Measure this machine for that time and compare it with the cycle of the cell."""
    return _measure({}, seconds, cell.cycle_ms, language, as_json=as_json)


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
        tool.add_argument("--count", type=int, default=COUNT, help="number of echoes (default %(default)s)")
        tool.add_argument(
            "--seconds", type=float, default=SECONDS, help="how long the scheduling of this machine is measured (default %(default)s)"
        )
        tool.add_argument("--clock", type=int, choices=CLOCKS_MS, help="in ms: exit code 1 if the machine is not good for this cycle")
        tool.add_argument("--json", action="store_true", help="figures and verdict as one JSON object")
        tool.add_argument("--language", choices=LANGUAGES, help="language of the report (default: the system's)")
        if name == "serial":
            tool.add_argument("--format", default="115200 8N1", help="character format of the line (default %(default)s)")
        else:
            tool.add_argument("--send", action="store_true", help="send on a real bus too: frames with identifier 7FFh")
    return parser


Echoes = dict[str, tuple[Callable[[], Sequence[float]], float]]


def _measure(echoes: Echoes, seconds: float, clock: int | None, language: str, *, as_json: bool) -> int:
    try:
        measured = [Measured(what, sorted(times()), share) for what, (times, share) in echoes.items()]
        measured.append(Measured("scheduling of this machine", sorted(lateness(seconds, progress(_in("scheduling", language)))), SHARE))
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
        print("\n".join(lines(measured, clock, language)))
    return Exit.OK if found.good is not None and found.good <= (clock or EVERY_MS) else Exit.FINDING


def lines(measured: Sequence[Measured], clock: int | None, language: str = "en") -> list[str]:
    """Figures, verdict and the next step, as printed."""
    found = verdict(measured)
    rows = []
    for each in measured:
        figures = ", ".join(f"{_in(name, language)} {value:g}" for name, value in each.figures().items())
        rows.append(f"{_in(each.what, language)}, ms: {figures}")
    slow = found.good is None or (clock is not None and found.good > clock)
    return [*rows, _in(found.words, language), *([_in(NEXT, language)] if slow else [])]


def _in(sentence: str, language: str) -> str:
    return spoken("doctor").german(sentence) if language == "de" else sentence


def _said(words: str, code: Exit) -> int:
    complain("doctor", words)
    return code
