"""Times measured with real ports and the real scheduler, in ms."""

import contextlib
import functools
import os
import select
import sys
import time
from collections.abc import Callable

from drivers.ports.base import BytePort, CanPort
from drivers.ports.can.adapter_url import is_adapter
from drivers.ports.can.open import open_can
from drivers.ports.open import open_bytes
from gateway.runtime.realtime import Timerfd
from protocols.base.machine import Frame

PATIENCE_S = 1.0  # for one echo
LOWEST = 0x7FF  # identifier with the lowest priority
PERIOD_NS = 1_000_000
PRIORITY = 40
Said = Callable[[float], None]  # share of the work that is done


class NoEcho(Exception):
    """No echo was received; the text names what to check."""


def progress(what: str) -> Said:
    """Progress in percent on standard error; nothing where that is not a terminal."""
    if not sys.stderr.isatty():
        return lambda share: None
    shown = [-1]

    def said(share: float) -> None:
        percent = min(round(share * 100), 100)
        if percent != shown[0]:
            shown[0] = percent
            print(f"\r{what}: {percent:3} %", end="\n" if percent == 100 else "", file=sys.stderr, flush=True)

    return said


def serial_echo(url: str, line_format: str, count: int, said: Said) -> list[float]:
    """Times from writing a character to reading its echo, less its time on the line.  Raises PortError, NoEcho, ValueError."""
    port = open_bytes(url, line_format)
    try:
        port.read()  # characters already on the line
        times = []
        for number in range(count):
            byte = bytes((number % 251,))
            start = time.monotonic_ns()
            port.write(byte)
            _until_heard(port.fileno(), functools.partial(_read, port, byte), url)
            times.append(max(0.0, (time.monotonic_ns() - start - port.char_ns) / 1e6))
            said((number + 1) / count)
        return times
    finally:
        port.close()


def can_echo(url: str, count: int, said: Said) -> list[float]:
    """Times from sending a frame until another listener of the channel has it; for an adapter that opens once, until it returns the
    frame.  Raises PortError, NoEcho."""
    if is_adapter(url):
        return _own_echo(url, count, said)
    sender, listener = open_can(url), open_can(url)
    try:
        times = []
        for number in range(count):
            frame = Frame(LOWEST, bytes((number % 256,)))
            start = time.monotonic_ns()
            while not sender.send([frame]):
                if time.monotonic_ns() - start > PATIENCE_S * 1e9:
                    raise NoEcho(
                        f"{url}: accepts no frame; is it up, and does another node acknowledge? axisgate doctor --can reports its state"
                    )
                time.sleep(0.0005)
            _until_heard(listener.fileno(), functools.partial(_received, listener, frame.data), url)
            times.append((time.monotonic_ns() - start) / 1e6)
            said((number + 1) / count)
            sender.receive()
        return times
    finally:
        sender.close()
        listener.close()


def _own_echo(url: str, count: int, said: Said) -> list[float]:
    from drivers.ports.can.adapter import AdapterPort

    port, times = AdapterPort(url), []
    try:
        for number in range(count):
            port.send([Frame(LOWEST, bytes((number % 256,)))])
            end = time.monotonic() + PATIENCE_S
            while not port.own_ns:
                if time.monotonic() > end:
                    raise NoEcho(f"{url}: does not echo own frames; axisgate run derives its latency from the drives' first answers")
                select.select([port], [], [], PATIENCE_S)
                port.receive()
            times.append(port.own_ns.pop() / 1e6)
            said((number + 1) / count)
        return times
    finally:
        port.close()


def _read(port: BytePort, byte: bytes) -> bool:
    return any(isinstance(part, bytes) and byte in part for part in port.read())


def _received(port: CanPort, data: bytes) -> bool:
    return any(frame.identifier == LOWEST and frame.data == data for frame in port.receive())


def _until_heard(fd: int, heard: Callable[[], bool], url: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while (left := end - time.monotonic()) > 0:
        if select.select([fd], [], [], left)[0] and heard():
            return
    raise NoEcho(
        f"{url}: no echo within {PATIENCE_S:g} s; bridge its send and receive lines (RS-232: pins 2 and 3), or plug in a loop plug"
    )


def lateness(seconds: float, said: Said) -> list[float]:
    """How late a process wakes that is due every millisecond, with real-time priority where it is granted."""
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    with contextlib.suppress(OSError):  # refused: then the cycle's is refused too
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    timer = Timerfd()
    times: list[float] = []
    try:
        due = time.monotonic_ns() + PERIOD_NS
        end = due + round(seconds * 1e9)
        while due < end:
            timer.set(due)
            select.select([timer], [], [])
            now = time.monotonic_ns()
            times.append((now - due) / 1e6)
            due += PERIOD_NS * (1 + (now - due) // PERIOD_NS)  # one lateness is counted once
            if len(times) % 256 == 0:
                said(1 - (end - due) / (seconds * 1e9))
        said(1.0)
        return times
    finally:
        timer.close()
        os.sched_setscheduler(0, policy, priority)
