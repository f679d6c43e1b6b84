"""The serial port over a real tty driver of the guest (/dev/ttyS1 crossed with /dev/ttyS2): exclusive use, marks, frame.

The guest's driver has no frame of its own: it stays at 38400 8N1 whatever is asked.  So these tests show what the port asks of a
driver for 8E1, and that it does not run on a line whose driver kept another frame; a parity error takes a real interface.
"""

import asyncio
import errno
import os
import termios
import time
from typing import Any

import pytest

from drivers.ports.base import BytePort, PortError
from drivers.ports.open import open_bytes
from gateway.links.serial.runner import LineRunner
from hil_tests.lab.virtual.echo_machine import EchoMachine, Event, Heard
from protocols.base.machine import Damage, Ns

pytestmark = pytest.mark.vcan

ONE, OTHER = "/dev/ttyS1", "/dev/ttyS2"
GUEST_FRAME = "38400 8N1"


def hear(port: BytePort, count: int, limit_s: float = 5.0) -> list[bytes | Damage]:
    """Reads until that many good characters came or the limit is over."""
    items: list[bytes | Damage] = []
    end = time.monotonic() + limit_s
    while sum(len(item) for item in items if isinstance(item, bytes)) < count and time.monotonic() < end:
        items += port.read()
        time.sleep(0.0005)
    return items


def test_8e1_with_parity_check_and_marks_is_what_the_driver_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[Any]] = []
    real = termios.tcsetattr

    def note(fd: int, when: int, settings: list[Any]) -> None:
        asked.append(list(settings))
        real(fd, when, settings)

    monkeypatch.setattr(termios, "tcsetattr", note)
    with pytest.raises(PortError, match="the driver keeps 38400 8N1 where 9600 8E1 was asked") as caught:
        open_bytes(ONE, "9600 8E1")
    assert caught.value.errno == errno.EINVAL
    flags, speed = asked[-1][2], asked[-1][5]
    assert flags & termios.PARENB
    assert not flags & termios.PARODD
    assert flags & termios.CSIZE == termios.CS8
    assert not flags & termios.CSTOPB
    assert speed == termios.B9600


def test_a_frame_that_is_not_taken_is_named_whatever_the_line_was_used_for_before() -> None:
    open_bytes(ONE, GUEST_FRAME).close()
    with pytest.raises(PortError, match="the driver keeps 38400 8N1 where 9600 8E1 was asked"):  # now nothing but the frame is new
        open_bytes(ONE, "9600 8E1")


def test_marks_are_on_and_nothing_else_touches_the_characters() -> None:
    port = open_bytes(ONE, GUEST_FRAME)
    try:
        iflag, oflag, _cflag, lflag = termios.tcgetattr(port.fileno())[:4]
        assert iflag == termios.PARMRK
        assert not oflag & termios.OPOST
        assert not lflag & (termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN)
        assert not os.get_blocking(port.fileno())
    finally:
        port.close()


def test_the_port_has_one_user_until_it_is_closed() -> None:
    port = open_bytes(ONE, GUEST_FRAME)
    with pytest.raises(PortError, match=f"{ONE}: is used by another program"):
        open_bytes(ONE, GUEST_FRAME)
    port.close()
    open_bytes(ONE, GUEST_FRAME).close()


def test_every_character_crosses_the_driver_ff_among_them() -> None:
    one, other = open_bytes(ONE, GUEST_FRAME), open_bytes(OTHER, GUEST_FRAME)
    try:
        every = bytes(range(256)) + b"\xff\xff\x00\x10"
        assert one.write(every) == len(every)
        items = hear(other, len(every))
        assert all(isinstance(item, bytes) for item in items), "no character reads as damage"
        assert b"".join(item for item in items if isinstance(item, bytes)) == every
        assert one.unsent() > 200, "the pace is that of the line, not of the driver's queue"
        limit = time.monotonic() + 1
        while one.unsent() and time.monotonic() < limit:
            time.sleep(0.001)
        assert one.unsent() == 0
    finally:
        one.close()
        other.close()


def test_a_missing_interface_is_named_with_what_to_do() -> None:
    with pytest.raises(PortError, match=r"/dev/ttyUSB77: is not there; plug the adapter in") as caught:
        open_bytes("/dev/ttyUSB77", "9600 8E1")
    assert caught.value.errno == errno.ENOENT


def test_two_line_runners_talk_over_the_driver() -> None:
    async def play() -> bytes:
        heard = bytearray()

        def note(event: Event, now: Ns) -> None:
            if isinstance(event, Heard):
                heard.extend(event.data)

        machine = EchoMachine()
        asking = LineRunner(lambda: open_bytes(ONE, GUEST_FRAME), machine, note)
        answering = LineRunner(lambda: open_bytes(OTHER, GUEST_FRAME), EchoMachine(answer=True), lambda event, now: None)
        limit = time.monotonic() + 5
        while not (asking.state.connected and answering.state.connected) and time.monotonic() < limit:
            await asyncio.sleep(0.01)
        machine.say(b"\x02\xff\x10")
        asking.kick()
        while len(heard) < 3 and time.monotonic() < limit:
            await asyncio.sleep(0.01)
        asking.close()
        answering.close()
        return bytes(heard)

    assert asyncio.run(play()) == b"\x02\xff\x10"
