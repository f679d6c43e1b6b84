"""VAL 3 sio, serial line: a pty pair; the test holds the other end."""

import asyncio
import os
import pathlib
import termios
import time
from collections.abc import Iterator

import pytest

from drivers.ports.serial.line_format import escape
from drivers.ports.serial.pty import offer_marks
from gateway.links.serial.val3_channels import SioRunner
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.control import Value
from hil_tests.lab.virtual.val3_loop import code, play

RUNNER = "gateway.links.serial.val3_channels:SioRunner."
WIRE = "gateway.links.serial.val3_wires:SerialWire."
NAME = "Serial\\1"


class Pair:
    """A pty behind a path that stays; `remove` and `insert` are the adapter."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        self.master = -1
        self.insert()

    def insert(self) -> None:
        self.master, slave = os.openpty()
        self.path.symlink_to(os.ttyname(slave))
        offer_marks(slave)  # damage comes in PARMRK form, as from the line process
        os.close(slave)

    def remove(self) -> None:
        self.path.unlink()
        os.close(self.master)
        self.master = -1

    def say(self, data: bytes) -> None:
        os.write(self.master, escape(data))

    def hear(self, count: int) -> bytes:
        heard = b""
        while len(heard) < count:
            heard += os.read(self.master, 99)
        return heard

    def channel(self, timeout_s: float = 0.0) -> Channel:
        return Channel(NAME, Kind.SERIAL, device=f"pty:{self.path}", timeout_s=timeout_s)


@pytest.fixture
def pair(tmp_path: pathlib.Path) -> Iterator[Pair]:
    made = Pair(tmp_path / "tty")
    yield made
    if made.master >= 0:
        made.remove()


@pytest.mark.requirement("VAL-SIO-01", "VAL-SIO-04", by=(RUNNER + "get", WIRE + "read", RUNNER + "_watch"))
def test_sio_get_waits_for_the_line_without_end_when_the_time_out_is_0(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio, data = runner.variable(NAME), [0.0] * 3
        waiting = asyncio.get_running_loop().create_task(runner.get(sio, data))
        await asyncio.sleep(0.3)
        assert not waiting.done()
        pair.say(b"\x01\xff\x03\x04\x05")
        assert await asyncio.wait_for(waiting, 3) == 3 and data == [1.0, 255.0, 3.0]
        assert await asyncio.wait_for(runner.get(sio, data), 3) == 2 and data == [4.0, 5.0, 3.0]

    play(act, pair.channel(0))


@pytest.mark.requirement("VAL-SIO-02", "VAL-SIO-10", by=(RUNNER + "_on_time", RUNNER + "_arm"))
def test_a_silent_line_gives_0_after_the_time_and_the_operator_an_error(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio, started = runner.variable(NAME), time.monotonic()
        assert await asyncio.wait_for(runner.get(sio, [0.0]), 3) == 0
        middle = time.monotonic()
        assert await code(runner.read_text(sio)) == 125
        assert 0.29 <= middle - started < 1 and 0.29 <= time.monotonic() - middle < 1

    play(act, pair.channel(0.3))


@pytest.mark.requirement("VAL-SIO-06", "VAL-SIO-07", "VAL-SIO-09", by=(WIRE + "write", RUNNER + "_write"))
def test_what_is_written_is_on_the_line(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        assert await asyncio.wait_for(runner.set(sio, [256.4, -1.0]), 3) == 2
        assert await runner.write_text(sio, "ab") == "ab"
        assert await runner.write_num(sio, 65.4) == 65.0
        assert await asyncio.to_thread(pair.hear, 6) == b"\x00\xffab\rA"

    play(act, pair.channel(1))


@pytest.mark.requirement("VAL-SIO-17", "VAL-SIO-18", by=(RUNNER + "control", RUNNER + "_reopen"))
def test_the_example_of_the_manual_and_a_frame_the_port_has_not(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        example: list[tuple[str, Value]] = [
            ("baudRate", 115200), ("bits", 8), ("parity", "none"), ("stopBits", 1), ("timeout", 0), ("endOfString", 13),
        ]  # fmt: skip
        assert [await runner.control(sio, name, value) for name, value in example] == [0] * 6
        before = runner.core.channel(NAME)
        assert before.frame == "115200 8N1"
        assert await runner.control(sio, "bits", 5) == 0
        assert runner.core.channel(NAME).frame == "115200 5N1"
        assert await runner.control(sio, "stopBits", 2) == -3  # the manual has it, no UART has: one and a half there
        assert runner.core.channel(NAME).frame == "115200 5N1"
        assert await runner.control(sio, "bits", 8) == 0
        assert runner.core.channel(NAME) == before
        assert await runner.control(sio, "flowControl", "hardware") == 0
        (descriptor,) = runner.descriptors(sio)
        assert termios.tcgetattr(descriptor)[2] & termios.CRTSCTS
        waiting = asyncio.get_running_loop().create_task(runner.read_text(sio))
        await asyncio.sleep(0.05)
        assert await runner.control(sio, "parity", "even") == -4
        pair.say(b"go\r")
        assert await asyncio.wait_for(waiting, 3) == "go"

    play(act, pair.channel())


@pytest.mark.parametrize(("bits", "heard"), [(5, b"\x1f\x01"), (6, b"\x3f\x01"), (7, b"\x7f\x41"), (8, b"\xff\x41")])
def test_characters_of_five_to_eight_bits_leave_as_a_uart_sends_them(pair: Pair, bits: int, heard: bytes) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        assert await runner.control(sio, "bits", bits) == 0
        assert await asyncio.wait_for(runner.set(sio, [255.0, 65.0]), 3) == 2
        assert await asyncio.to_thread(pair.hear, 2) == heard

    play(act, pair.channel(1))


def test_two_tasks_that_change_the_frame_at_once_both_have_their_way(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        changes = [runner.control(sio, "baudRate", 19200), runner.control(sio, "parity", "even"), runner.control(sio, "timeout", 0.2)]
        assert await asyncio.gather(*changes) == [0, 0, 0]
        assert (runner.core.channel(NAME).frame, runner.core.channel(NAME).timeout_s) == ("19200 8E1", 0.2)
        pair.say(b"go\r")
        assert await runner.read_text(sio) == "go"

    play(act, pair.channel())


def test_a_frame_changed_while_the_adapter_is_out_holds_when_it_is_back(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        pair.remove()
        assert await runner.get(sio, [0.0]) == -1
        assert await runner.control(sio, "flowControl", "hardware") == 0
        pair.insert()
        while await runner.set(sio, [120.0]) != 1:
            await asyncio.sleep(0.05)
        (descriptor,) = runner.descriptors(sio)
        assert termios.tcgetattr(descriptor)[2] & termios.CRTSCTS

    play(act, pair.channel(1))


@pytest.mark.requirement("VAL-SIO-16", by=(RUNNER + "clear_buffer", "gateway.pure.controllers.val3.sio.line:Line.clear"))
def test_clear_buffer_counts_what_waits_in_the_kernel_too(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        pair.say(b"old")
        time.sleep(0.05)  # the loop does not run meanwhile
        assert runner.clear_buffer(sio) == 3
        assert runner.clear_buffer(sio) == 0
        assert await runner.get(sio, [0.0]) == 0

    play(act, pair.channel(0.1))


def test_a_parity_error_is_reported_in_its_place(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio, data = runner.variable(NAME), [0.0] * 9
        os.write(pair.master, b"ab\xff\x00xcd\r")
        assert [await runner.get(sio, data), await runner.get(sio, data)] == [2, -1]
        assert await runner.read_text(sio) == "cd"

    play(act, pair.channel(1))


def test_an_adapter_that_is_pulled_is_an_error_and_comes_back_by_itself(pair: Pair) -> None:
    async def act(runner: SioRunner) -> None:
        sio, data = runner.variable(NAME), [0.0]
        waiting = asyncio.get_running_loop().create_task(runner.get(sio, data))
        await asyncio.sleep(0.05)
        pair.remove()
        assert await asyncio.wait_for(waiting, 3) == -1
        assert await code(runner.write_text(sio, "x")) == 125
        pair.insert()
        while await runner.set(sio, [120.0]) != 1:
            await asyncio.sleep(0.05)
        assert await asyncio.to_thread(pair.hear, 1) == b"x"

    play(act, pair.channel(2))


def test_a_port_that_is_not_there_yet_is_waited_for(tmp_path: pathlib.Path) -> None:
    pair = Pair(tmp_path / "late")
    channel = pair.channel(2)
    pair.remove()

    async def act(runner: SioRunner) -> None:
        sio = runner.variable(NAME)
        assert await runner.get(sio, [0.0]) == -1
        pair.insert()
        while await runner.set(sio, [120.0]) != 1:
            await asyncio.sleep(0.05)
        assert await asyncio.to_thread(pair.hear, 1) == b"x"

    play(act, channel)
    pair.remove()
