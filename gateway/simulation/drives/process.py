"""The emulated drives of one bus as a process.

    python -m gateway.simulation.drives.process --settings FILE.json --bus broker:NAME [--name NAME] [--record FILE] [--layout FILE.dbc]

Settings: drivers.emulator.servo.settings ("axes": SERVODYN boosters, "nodes": CiA 402 drives, either or both); record:
drivers.emulator.servo.record
(with both families the nodes' is FILE.nodes); commands: gateway.simulation.drives.control, for nodes emulator_nodes.  Prints `ready` when
it is on the bus.  A bus that goes away is opened again; the plant keeps its state.  Exit codes: 0 stopped, 2 wrong arguments or
settings, 3 name taken or record not writable.
"""

import argparse
import contextlib
import errno
import json
import os
import pathlib
import select
import signal
import sys
import time
from collections.abc import Callable, Sequence
from typing import IO

from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.io.belts import EmulatedBelt, EmulatedBelts
from drivers.emulator.servo.settings import BusSettings, SettingsError, from_dict
from drivers.emulator.servodyn.slave import ServodynSlave
from drivers.emulator.wire.frame_faults import FrameFaults, Way
from drivers.emulator.wire.mixed_bus import BothFamilies
from drivers.emulator.wire.stretched_time import NAP_NS, StretchedTime
from drivers.ports.base import CanPort, PortError
from drivers.ports.can.remote_frames import open_can_with_remotes
from gateway.cycle.native.servo import use_servo
from gateway.files.dbc import load_servodyn
from gateway.files.find import find_config
from gateway.runtime.realtime import die_with_parent, go_realtime
from gateway.simulation.control_requests import Answer, Command
from gateway.simulation.drives.belts import belts_from, carry_out_belt
from gateway.simulation.drives.control import ControlServer, carry_out
from gateway.simulation.drives.frame_faults import ORDERS, carry_out_frames
from gateway.simulation.drives.node_faults import carry_out_node
from protocols.base.errors import ProtocolError
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import eds
from protocols.canopen.dictionary import ObjectDictionary
from protocols.servodyn.plan import SYNC_ID

PRIORITY = 20  # SCHED_FIFO, below broker (30)
LAYOUT = "servodyn_gc.dbc"
Slave = ServodynSlave | Cia402Slave | BothFamilies
RECORD_CHUNK = 32_768  # bytes written at once
RECORD_NS = ms(250)  # at the latest
RECORD_MOST = 4 << 30  # bytes of a file: a day of six axes at 4 ms; a flood of SYNC ends there, too
REOPEN_NS = ms(50)


class Recorder:
    """Writes rows to a file in plain writes of full chunks, when the bus leaves time."""

    def __init__(self, file: IO[bytes] | None) -> None:
        self._file = file
        self._rows = bytearray()
        self._due: Ns = 0
        self.written = self.lost = 0

    @property
    def due(self) -> Ns | None:
        return self._due if self._rows else None

    def add(self, rows: bytes, now: Ns) -> None:
        """Call it without rows too: waiting rows are written when due."""
        if self._file is None or not (rows or self._rows):
            return
        if not self._rows:
            self._due = now + RECORD_NS
        self._rows += rows
        if len(self._rows) >= RECORD_CHUNK or now >= self._due:
            self.flush()

    def flush(self) -> None:
        """A full disk is counted and reported once, it does not stop the drives."""
        if self._file is None or not self._rows:
            return
        try:
            if self.written + len(self._rows) > RECORD_MOST:
                raise OSError(errno.EFBIG, f"it has {RECORD_MOST >> 20} MiB, its bound")
            self._file.write(self._rows)
            self.written += len(self._rows)
        except OSError as error:
            if not self.lost:
                print(f"emulator: record: {error}; drives run on without", file=sys.stderr, flush=True)
            self.lost += len(self._rows)
        self._rows.clear()


class Emulator:
    """One loop around one slave machine and one port; `turn` is one round."""

    def __init__(
        self,
        name: str,
        slave: Slave,
        open_port: Callable[[], CanPort],
        *recorders: Recorder,
        belts: Sequence[EmulatedBelt] = (),
        stretched: StretchedTime | None = None,
    ) -> None:
        self.slave, self.stopping, self.belts = slave, False, EmulatedBelts(belts)
        self._stretched = stretched
        self.faults = FrameFaults()
        self._recorded = list(zip(families(slave), recorders, strict=True))
        self._open_port = open_port
        self._port: CanPort | None = None
        self._reopen: Ns = 0
        self._epoll = select.epoll()
        self._said = ""
        self.refused = self.opened = 0
        self.control = ControlServer(name, self._epoll, self._carry)
        for family, recorder in self._recorded:
            recorder.add(family.header(), 0)

    @property
    def connected(self) -> bool:
        return self._port is not None

    def watch(self, fd: int) -> None:
        """Another descriptor that ends the wait of a turn; its owner reads it."""
        self._epoll.register(fd, select.EPOLLIN)

    def open(self) -> None:
        """Opens the port when it is time to; a quiet bus would keep the next turn waiting."""
        now = time.monotonic_ns()
        if self._port is None and now >= self._reopen:
            self._connect(now)

    def turn(self) -> None:
        """Waits for a frame, a command or a deadline, then does everything that is to be done."""
        self.open()
        ready = self._epoll.poll(self._timeout_s(self._now()))
        now = self._now()  # before the port is drained: frames stamped before now minus the grace are then already here
        synced = self._drain(now)
        now = now if self._stretched is None else self._now()  # a received SYNC lets time continue
        self.slave.wake(now - self.slave.grace_ns)
        self._send(now)
        if synced:
            self.slave.prepare()
        self._record(now)
        for fd, _ in ready:
            self.control.ready(fd)
        self._send(now)  # frames caused by a command

    def _now(self) -> Ns:
        """As the drives count it."""
        now = time.monotonic_ns()
        return now if self._stretched is None else self._stretched.at(now)

    def close(self) -> None:
        self._flush()
        self.control.close()
        if self._port is not None:
            self._port.close()
        self._epoll.close()

    def _timeout_s(self, now: Ns) -> float:
        dues = [recorder.due for _, recorder in self._recorded if recorder.due is not None]
        due, deadline = min(dues, default=None), self.slave.deadline()
        if deadline is not None:
            deadline += self.slave.grace_ns
            due = deadline if due is None else min(due, deadline)
        if self._port is None:
            due = self._reopen if due is None else min(due, self._reopen)
        late = self.faults.due()
        if late is not None:
            due = late if due is None else min(due, late)
        if due is not None and self._stretched is not None and self._stretched.held(time.monotonic_ns()):
            due = max(due, now + NAP_NS)  # due actions wait for the SYNC, or for the end of the wait for it
        return -1.0 if due is None else max(0, due - now) * 1e-9

    def _drain(self, now: Ns) -> bool:
        """Hands in everything that waits; True when there was something."""
        heard = False
        try:
            while self._port is not None and (frames := self._port.receive()):
                if self._stretched is not None:
                    frames = self._stretched.frames(frames)
                    now = self._now()
                self._hear(frames, now)
                heard = True
            if not self.faults.idle:
                self._hear([], now)  # those that come late
            for kind, _ in self._port.take_faults() if self._port is not None else ():
                self.slave.error_frame(kind, now)
        except PortError as error:
            self._lost(now, error)
        return heard

    def _hear(self, frames: list[Frame], now: Ns) -> None:
        frames = self.faults.through(Way.IN, frames, now)
        if frames:
            self.slave.receive(frames, now)
            self.belts.receive(frames)

    def _send(self, now: Ns) -> None:
        frames = self.faults.through(Way.OUT, [*self.belts.take_output(), *self.slave.take_output()], now)
        if not frames or self._port is None:
            return
        try:
            self.refused += len(frames) - self._port.send(frames)
            self.slave.sent(now)
        except PortError as error:
            self._lost(now, error)

    def _connect(self, now: Ns) -> None:
        try:
            self._port = self._open_port()
        except PortError as error:
            self._reopen = now + REOPEN_NS
            self._say(str(error))
            return
        self._epoll.register(self._port.fileno(), select.EPOLLIN)
        self.opened += 1
        self._say("")

    def _lost(self, now: Ns, error: PortError) -> None:
        assert self._port is not None
        self._epoll.unregister(self._port.fileno())
        self._port.close()
        self._port, self._reopen = None, now
        self.slave.lost(now)
        self._say(str(error))

    def _say(self, text: str) -> None:
        if text and text != self._said:
            print(f"emulator: {text}", file=sys.stderr, flush=True)
        self._said = text

    def _carry(self, command: Command) -> Answer:
        match command.get("do"):
            case "quit":
                self.stopping = True
                return {}
            case "flush":
                self._flush()
                written = sum(recorder.written for _, recorder in self._recorded)
                return {"record_bytes": written, "record_lost": self.record_lost}
            case "state":
                own = {"connected": self.connected, "opened": self.opened, "refused": self.refused, "record_lost": self.record_lost}
                spoilt = {kind.value: count for kind, count in self.faults.spoilt.items()}
                frames = {**spoilt, "silenced": self.faults.silenced}
                return {**self._carry_family(command), **own, "frames": frames, "belts": self.belts.state()}
            case "belt":
                return carry_out_belt(self.belts, command)
            case str() as what if what in ORDERS:
                return carry_out_frames(self.faults, command, self._now())
            case _:
                return self._carry_family(command)

    def _carry_family(self, command: Command) -> Answer:
        """Pass to the nodes a command that names one; the state of two families combined."""
        slave = self.slave
        if isinstance(slave, BothFamilies):
            if command.get("do") == "state":
                return {**carry_out_node(slave.cia402, command), **carry_out(slave.servodyn, command)}
            return carry_out_node(slave.cia402, command) if "node" in command else carry_out(slave.servodyn, command)
        return carry_out_node(slave, command) if isinstance(slave, Cia402Slave) else carry_out(slave, command)

    @property
    def record_lost(self) -> int:
        return sum(recorder.lost for _, recorder in self._recorded)

    def _record(self, now: Ns) -> None:
        for family, recorder in self._recorded:
            recorder.add(family.take_record(), now)

    def _flush(self) -> None:
        self._record(0)
        for _, recorder in self._recorded:
            recorder.flush()


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m gateway.simulation.drives.process", description="Emulated drives on a bus.")
    parser.add_argument("--settings", required=True, type=pathlib.Path, help="JSON file, see drivers.emulator.servo.settings")
    parser.add_argument("--bus", required=True, help="broker:NAME or socketcan:INTERFACE")
    parser.add_argument("--name", help="of the control socket (default: the bus' name)")
    parser.add_argument("--record", type=pathlib.Path, help="file for the drives' own record")
    parser.add_argument("--belts", default="[]", help="JSON: a list of belts with an encoder on this bus, see drivers.emulator.io.belts")
    parser.add_argument("--layout", default=LAYOUT, help="DBC file (default %(default)s)")
    parser.add_argument("--priority", type=int, default=PRIORITY, help="SCHED_FIFO priority, 0: none (default %(default)s)")
    parser.add_argument("--stretched", type=int, metavar="MS", help="simulated time waits for a SYNC that is late; clock in ms")
    parser.add_argument("--die-with-parent", action="store_true", help="end when the starting process ends")
    return parser.parse_args(argv)


def load(options: argparse.Namespace) -> Slave:
    """Raises OSError, ValueError (JSON, SettingsError) or ProtocolError (layout)."""
    settings = from_dict(json.loads(options.settings.read_text()))
    nodes = Cia402Slave(settings, dictionaries(settings)) if settings.nodes else None
    if nodes is not None and not settings.axes:
        return nodes
    boosters = ServodynSlave(settings, load_servodyn(find_config(options.layout, "drives")))
    return boosters if nodes is None else BothFamilies(boosters, nodes)


def stretched(options: argparse.Namespace) -> StretchedTime | None:
    """If the command line requests it."""
    return None if options.stretched is None else StretchedTime(ms(options.stretched), {SYNC_ID, cobid.SYNC})


def dictionaries(settings: BusSettings) -> dict[int, ObjectDictionary]:
    """The object dictionary of each node, from the EDS its settings name; faults of a file are reported."""
    read: dict[str, ObjectDictionary] = {}
    for name in sorted({drive.eds for drive in settings.nodes.values()}):
        read[name], faults = eds.parse(find_config(name, "drives").read_bytes().decode("utf-8", "replace"))
        for fault in faults:
            print(f"emulator: {name}: {fault}", file=sys.stderr)
    return {number: read[drive.eds] for number, drive in settings.nodes.items()}


def families(slave: Slave) -> list[ServodynSlave | Cia402Slave]:
    """Families with a record of their own."""
    return [slave.servodyn, slave.cia402] if isinstance(slave, BothFamilies) else [slave]


def run(emulator: Emulator) -> None:
    """Until SIGTERM, SIGINT or the command quit."""
    inside, outside = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(outside, warn_on_full_buffer=False)

    def stop(number: int, frame: object) -> None:
        emulator.stopping = True

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    emulator.watch(inside)
    announced = False
    while not emulator.stopping:
        emulator.open()
        if emulator.connected and not announced:
            announced = True
            print("ready", flush=True)
        emulator.turn()


def main(argv: list[str] | None = None) -> int:
    options = arguments(argv)
    if options.die_with_parent:
        die_with_parent()
    use_servo()
    try:
        slave, belts = load(options), belts_from(options.belts)
    except SettingsError as error:
        print("\n".join(f"{options.settings}: {fault}" for fault in error.faults), file=sys.stderr)
        return 2
    except (OSError, ValueError, ProtocolError) as error:
        print(f"emulator: {error}", file=sys.stderr)
        return 2
    try:
        with contextlib.ExitStack() as files:
            names = [options.record, options.record and options.record.with_name(options.record.name + ".nodes")][: len(families(slave))]
            recorders = [Recorder(files.enter_context(open(name, "wb", buffering=0)) if name else None) for name in names]
            name = options.name or options.bus.partition(":")[2]
            emulator = Emulator(
                name, slave, lambda: open_can_with_remotes(options.bus), *recorders, belts=belts, stretched=stretched(options)
            )
            for warning in go_realtime(options.priority) if options.priority else []:
                print(f"emulator: {warning}", file=sys.stderr, flush=True)
            try:
                run(emulator)
            finally:
                emulator.close()
    except OSError as error:
        print(f"emulator: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
