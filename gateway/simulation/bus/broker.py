"""The local bus as a process: python -m gateway.simulation.bus.broker --name NAME [--log FILE].

One thread, one epoll: a plain bus passes frames on at once, one with --bitrate after their time on a wire (wired_broker).
"""

import argparse
import contextlib
import fcntl
import os
import signal
import socket
import sys

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.can.broker import socket_path
from gateway.runtime.life import Life
from gateway.runtime.realtime import die_with_parent, go_realtime
from gateway.simulation.bus.base import QUEUE_FRAMES, Broker
from gateway.simulation.bus.log import LogPipe

PRIORITY = 30


def bind(name: str) -> socket.socket:
    """The listening socket; replaces the file of a dead broker, PortError when a living one has the name."""
    path = socket_path(name)
    folder = os.open(runtime_dir(), os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)  # two starting at once: one waits for the other
        if os.path.lexists(path):
            if _alive(path):
                raise PortError(f"broker:{name}: another broker of this name is running ({path})")
            os.unlink(path)
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET | socket.SOCK_NONBLOCK)
        listener.bind(path)
        listener.listen(64)
    finally:
        os.close(folder)
    return listener


def _alive(path: str) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET | socket.SOCK_NONBLOCK) as probe:
        try:
            probe.connect(path)
        except ConnectionRefusedError:
            return False
        except BlockingIOError:
            pass  # its queue is full: stopped, but alive
    return True


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m gateway.simulation.bus.broker", description="The local CAN bus.")
    parser.add_argument("--name", required=True, help="the bus is then broker:NAME")
    parser.add_argument("--log", help="file for all frames, as candump -L writes them, with the bus' monotonic stamps")
    parser.add_argument("--queue", type=int, default=QUEUE_FRAMES, help="frames that may wait for one subscriber (default %(default)s)")
    parser.add_argument("--priority", type=int, default=PRIORITY, help="SCHED_FIFO priority, 0: none (default %(default)s)")
    parser.add_argument("--bitrate", type=int, help="model the wire at so many bit/s: arbitration, stuffing, time (default: none)")
    parser.add_argument("--die-with-parent", action="store_true", help="end when the starting process ends")
    return parser.parse_args(argv)


def run(broker: Broker) -> None:
    """Turn until SIGTERM or SIGINT; SIGUSR1 prints the counters."""
    wanted: set[int] = set()
    inside, outside = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(outside, warn_on_full_buffer=False)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
        signal.signal(number, lambda caught, _: wanted.add(caught))
    broker.register(inside)
    life = Life()
    print("ready", flush=True)
    while not wanted & {signal.SIGTERM, signal.SIGINT}:
        broker.turn()
        life.beat()
        if wanted:
            with contextlib.suppress(BlockingIOError):
                os.read(inside, 64)
        if signal.SIGUSR1 in wanted:
            wanted.discard(signal.SIGUSR1)
            broker.note_stats()


def make(arguments: argparse.Namespace, listener: socket.socket, log: LogPipe | None) -> Broker:
    if arguments.bitrate is None:
        return Broker(arguments.name, listener, log, arguments.queue)
    from gateway.simulation.bus.wired_broker import WiredBroker  # only where a wire is modelled

    return WiredBroker(arguments.name, listener, log, arguments.queue, arguments.bitrate)


def main(argv: list[str] | None = None) -> int:
    """0 after SIGTERM; 2 command line, 3 the name is in use or the file cannot be written."""
    arguments = _arguments(argv)
    if arguments.die_with_parent:
        die_with_parent()
    try:
        listener = bind(arguments.name)
    except OSError as error:
        print(error, file=sys.stderr)
        return 3
    path = socket_path(arguments.name)
    try:
        log = LogPipe(arguments.log, arguments.name) if arguments.log else None
        broker = make(arguments, listener, log)
        for warning in go_realtime(arguments.priority) if arguments.priority else []:
            print(f"broker:{arguments.name}: {warning}", file=sys.stderr, flush=True)
        run(broker)
        broker.close()
    except ValueError as error:  # --bitrate
        print(error, file=sys.stderr)
        return 2
    except PortError as error:
        print(error, file=sys.stderr)
        return 3
    finally:
        os.unlink(path)
        listener.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
