"""A CAN adapter of python-can on the local bus of a run: python -m gateway.processes.can_adapter --bus broker:NAME --port
slcan:/dev/ttyACM0.

The cycle is on broker:NAME and never waits for a library (AX-435).  Its frames are passed on while they are fresh; frames the adapter
receives go to the local bus.  An adapter that was pulled is reopened when it is back.  At each opening the latency is measured by the
cycle's own frames and logged: nothing is sent for it.
"""

import argparse
import contextlib
import gc
import select
import signal
import time

from drivers.ports.base import PortError
from drivers.ports.can.adapter import SAMPLES, AdapterPort
from drivers.ports.can.broker import BrokerPort
from gateway.pure.reports.latency import Measured, verdict
from gateway.runtime.life import Life
from gateway.runtime.realtime import die_with_parent, go_realtime
from protocols.base.machine import Frame, Ns

PRIORITY = 30  # as the local bus
AGAIN_S = 0.3
TURN_S = 0.2
MS = 1_000_000


class Relay:
    """Both ports, and the way between them."""

    def __init__(self, bus: str, url: str, bitrate: int, fresh_ns: Ns, *, listen_only: bool) -> None:
        self._bus, self._url, self._bitrate, self._listen_only = bus.partition(":")[2], url, bitrate, listen_only
        self._fresh_ns = fresh_ns  # older frames prove nothing any more
        self._near: BrokerPort | None = None
        self._far: AdapterPort | None = None
        self._said = ""
        self._reported = self._faults_reported = self._fd_reported = False
        self._again = 0.0
        self.stale = self._stale_reported = 0

    def turn(self) -> None:
        """Wait for something and hand it on; a side that is away is opened again."""
        if self._near is None or self._far is None:
            self._open()
        ports = [port for port in (self._near, self._far) if port is not None]
        if not ports:
            time.sleep(TURN_S)
            return
        select.select(ports, (), (), TURN_S)
        try:
            self._out()
            self._in()
        except PortError as error:
            self._say(str(error))
            self._close_far()
        self._report()

    def _out(self) -> None:
        if self._near is None:
            return
        try:
            frames = self._near.receive()
        except PortError as error:
            self._near.close()
            self._near = None
            self._say(str(error))
            return
        limit = time.monotonic_ns() - self._fresh_ns
        fresh = [Frame(frame.identifier, frame.data) for frame in frames if frame.stamp_ns > limit]
        self.stale += len(frames) - len(fresh)
        if self._far is not None and fresh and not self._listen_only:
            self._far.send(fresh)

    def _in(self) -> None:
        if self._far is None:
            return
        frames = self._far.receive()
        if frames and self._near is not None:
            with contextlib.suppress(PortError):  # reported at the next receive()
                self._near.send(frames)

    def _open(self) -> None:
        now = time.monotonic()
        if now < self._again:
            return
        self._again = now + AGAIN_S
        gc.collect()  # automatic collection is off here, and failed attempts leave garbage
        try:
            if self._near is None:
                self._near = BrokerPort(self._bus)
            if self._far is None:
                self._far = AdapterPort(self._url, self._bitrate, listen_only=self._listen_only)
                self._reported = self._faults_reported = self._fd_reported = False
                self._said = ""
                print(f"{self._url}: open" + (", listening only" if self._listen_only else ""), flush=True)
        except PortError as error:
            self._say(str(error))

    def _report(self) -> None:
        """The latency once for each opening; error frames and frames that were too old when they first come."""
        far = self._far
        if self.stale > self._stale_reported:
            if not self._stale_reported:
                print(f"{self._url}: frames of the cycle were older than {self._fresh_ns / 1e6:g} ms and not forwarded", flush=True)
            self._stale_reported = self.stale
        if far is None:
            return
        if far.take_faults() and not self._faults_reported:
            self._faults_reported = True
            print(f"{self._url}: error frames on the bus: check cable, termination, bit rate", flush=True)
        if far.fd and not self._fd_reported:
            self._fd_reported = True
            print(f"{self._url}: frames of CAN FD on the bus: they are ignored, drives and couplers use classic CAN", flush=True)
        if not self._reported and (len(far.own_ns) >= SAMPLES or len(far.answer_ns) >= SAMPLES):
            self._reported = True
            print(f"{self._url}: {latency_words(far.own_ns, far.answer_ns)}", flush=True)

    def _say(self, words: str) -> None:
        if words != self._said:
            self._said = words
            print(words, flush=True)

    def _close_far(self) -> None:
        if self._far is not None:
            self._far.close()
            self._far = None

    def close(self) -> None:
        self._close_far()
        if self._near is not None:
            self._near.close()


def latency_words(own_ns: list[Ns], answer_ns: list[Ns]) -> str:
    """From own frames if the adapter echoes them, otherwise from the first answer to a burst."""
    times, what = (own_ns, "echo latency") if own_ns else (answer_ns, "own frames are not echoed; first answer to a burst")
    measured = Measured(what, sorted(each / 1e6 for each in times))
    figures = ", ".join(f"{name} {value:g}" for name, value in measured.figures().items())
    return f"{what}, ms: {figures}; {verdict([measured]).words}"


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m gateway.processes.can_adapter", description="A CAN adapter on the local bus of a run.")
    parser.add_argument("--bus", required=True, help="broker:NAME")
    parser.add_argument("--port", required=True, help="INTERFACE:CHANNEL[@BITRATE][?OPTION=VALUE&...]")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="bit/s if the port names none (default %(default)s)")
    parser.add_argument(
        "--fresh-ms", type=int, default=16, help="frames of the cycle older than this are not passed on (default %(default)s)"
    )
    parser.add_argument("--listen-only", action="store_true", help="pass nothing to the adapter")
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    stop = False

    def stopped(number: int, frame: object) -> None:
        nonlocal stop
        stop = True

    signal.signal(signal.SIGTERM, stopped)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    relay = Relay(arguments.bus, arguments.port, arguments.bitrate, arguments.fresh_ms * MS, listen_only=arguments.listen_only)
    life = Life()
    print("ready", flush=True)
    while not stop:
        relay.turn()
        life.beat()
    relay.close()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
