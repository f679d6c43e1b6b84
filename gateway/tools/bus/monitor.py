"""axisgate bus monitor: frames of a live bus or a recording, decoded; never sends."""

import argparse
import json
import pathlib
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import can
from cantools.database.errors import Error as DatabaseError

from drivers.ports.can.wire import ID_BITS, RTR_FLAG
from gateway.files.find import ConfigNotFound
from gateway.files.frame_decoder import Decode, decoder, named
from gateway.tools.bus.load import measured
from gateway.tools.bus.logs import BadLog, FdFrame, fd_frame_of, frame_of, read_log
from gateway.tools.bus.ports import FORM, NoBus, open_bus
from gateway.tools.command_support import DONE, ENVIRONMENT, USAGE, of_file
from gateway.tools.usage_language import complain
from protocols.base.machine import Frame, Ns

EXAMPLES = f"""examples:
  axisgate bus monitor socketcan:can0 --dbc servodyn_gc.dbc
  axisgate bus monitor broker:demo-drives --dbc servodyn_gc.dbc --summary --seconds 5
  axisgate bus monitor --from living.blf --canopen
a bus is {FORM}
exit code: 0 done, 2 command line or file, 3 no such bus"""


@dataclass(slots=True)
class Seen:
    """Statistics of one identifier."""

    count: int = 0
    first_ns: Ns = 0
    last_ns: Ns = 0
    shortest_ns: Ns = 0
    longest_ns: Ns = 0
    last: bytes = b""
    changes: int = 0

    def take(self, frame: Frame | FdFrame) -> None:
        if self.count:
            gap = frame.stamp_ns - self.last_ns
            self.shortest_ns = gap if self.count == 1 else min(self.shortest_ns, gap)
            self.longest_ns = max(self.longest_ns, gap)
            self.changes += frame.data != self.last
        else:
            self.first_ns = frame.stamp_ns
        self.count, self.last_ns, self.last = self.count + 1, frame.stamp_ns, frame.data

    def figures(self) -> str:
        """Its columns of the summary."""
        period = (self.last_ns - self.first_ns) / 1e6 / (self.count - 1) if self.count > 1 else 0.0
        return f"{self.count:8}{period:11.3f}{self.shortest_ns / 1e6:9.3f}{self.longest_ns / 1e6:9.3f}{self.changes:9}"


@dataclass(slots=True)
class Summary:
    """Rates and load of everything seen."""

    seen: dict[int, Seen] = field(default_factory=dict)
    frames: list[Frame] = field(default_factory=list)
    errors: int = 0
    remotes: int = 0
    fd: dict[int, Seen] = field(default_factory=dict)  # frames of CAN FD

    @property
    def fd_count(self) -> int:
        return sum(one.count for one in self.fd.values())

    def take(self, frame: Frame | FdFrame) -> None:
        if isinstance(frame, FdFrame):
            self.fd.setdefault(frame.identifier, Seen()).take(frame)
            return
        self.seen.setdefault(frame.identifier, Seen()).take(frame)
        self.frames.append(frame)
        self.remotes += bool(frame.identifier & RTR_FLAG)

    def lines(self, decode: Decode, rate: int) -> Iterator[str]:
        yield f"{'identifier':>14}{'frames':>8}{'period ms':>11}{'min':>9}{'max':>9}  changed  last"
        for identifier, one in sorted(self.seen.items()):
            yield f"{named(identifier):>14}{one.figures()}  {decode(Frame(identifier, one.last))}"
        for identifier, one in sorted(self.fd.items()):
            yield f"{named(identifier):>14}{one.figures()}  FD, {len(one.last)} bytes"
        total = measured(self.frames, rate)
        load = f"load {total['load_percent']:.2f} %, busiest 10 ms {total['busiest_percent']:.1f} %"
        yield f"{total['frames']} frames, {load}, remote frames {self.remotes}, error frames {self.errors}"
        if self.fd:
            yield f"{self.fd_count} frames of CAN FD, not in the load: drives and couplers here speak classic CAN"


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bus monitor", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bus", nargs="?", help=FORM)
    parser.add_argument("--from", dest="source", type=pathlib.Path, metavar="FILE", help="a recording in place of a bus")
    parser.add_argument("--dbc", help="decode by this DBC (given path, then the packaged drives)")
    parser.add_argument("--canopen", action="store_true", help="decode as CANopen")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="bit/s (default %(default)s)")
    parser.add_argument("--count", type=int, help="end after so many frames")
    parser.add_argument("--seconds", type=float, help="end after this time")
    parser.add_argument("--summary", action="store_true", help="only the table of identifiers at the end")
    parser.add_argument("--json", action="store_true", help="one JSON object a frame")
    arguments = parser.parse_args(argv)
    if (arguments.bus is None) == (arguments.source is None):
        complain("bus monitor", "name either a bus or --from FILE")
        return USAGE
    try:
        decode = decoder(arguments.dbc, canopen=arguments.canopen)
        if arguments.source is not None:
            return show(read_log(arguments.source), decode, arguments, Summary())
        with open_bus(arguments.bus, arguments.bitrate, fd=True) as bus:
            summary = Summary()
            return show(live(bus, arguments.seconds, summary), decode, arguments, summary)
    except NoBus as error:
        complain("bus monitor", error)
        return ENVIRONMENT
    except BrokenPipeError:
        raise
    except (BadLog, OSError, ConfigNotFound, DatabaseError) as error:
        complain("bus monitor", of_file(error))
        return USAGE


def live(bus: can.BusABC, seconds: float | None, summary: Summary) -> Iterator[Frame | FdFrame]:
    """Frames as they arrive, until Ctrl-C or `seconds` are over."""
    end = None if seconds is None else time.monotonic() + seconds
    try:
        while end is None or time.monotonic() < end:
            message = bus.recv(0.2 if end is None else max(0.0, min(0.2, end - time.monotonic())))
            if message is not None and message.is_error_frame:
                summary.errors += 1
            elif message is not None and message.is_fd:
                yield fd_frame_of(message)
            elif message is not None:
                yield frame_of(message)
    except KeyboardInterrupt:
        return


def show(frames: Iterable[Frame | FdFrame], decode: Decode, arguments: argparse.Namespace, summary: Summary) -> int:
    start: Ns | None = None
    for number, frame in enumerate(frames, 1):
        start = frame.stamp_ns if start is None else start
        summary.take(frame)
        if not arguments.summary:
            print(_line(frame, start, decode, as_json=arguments.json), flush=True)
        if arguments.count is not None and number >= arguments.count:
            break
    if arguments.summary:
        print("\n".join(summary.lines(decode, arguments.bitrate)))
    return DONE


def _line(frame: Frame | FdFrame, start: Ns, decode: Decode, *, as_json: bool) -> str:
    since = (frame.stamp_ns - start) / 1e6
    if isinstance(frame, FdFrame):
        if as_json:
            facts = {"fd": True, "fast": frame.fast, "text": f"FD, {len(frame.data)} bytes"}
            return json.dumps({"ms": round(since, 3), "id": frame.identifier & ID_BITS, "data": frame.data.hex(), **facts})
        words = f"FD{', fast' if frame.fast else ''}, {len(frame.data)} bytes: {frame.data.hex(' ')}"
        return f"{since:12.3f} ms {named(frame.identifier):>14}  {words}"
    if as_json:
        remote = {"remote": True, "dlc": len(frame.data)} if frame.identifier & RTR_FLAG else {}
        data = "" if remote else frame.data.hex()
        return json.dumps({"ms": round(since, 3), "id": frame.identifier & ID_BITS, "data": data, "text": decode(frame), **remote})
    if frame.identifier & RTR_FLAG:
        return f"{since:12.3f} ms {named(frame.identifier):>14}  {decode(frame)}"
    return f"{since:12.3f} ms {named(frame.identifier):>14}  {frame.data.hex(' '):24} {decode(frame)}"
