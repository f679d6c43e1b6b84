"""The rho 3's devices over a real line process: programs' calls on side A, a partner on side B."""

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable, Iterator

import pytest

from drivers.ports.base import BytePort
from gateway.links.serial.rho3_devices import Rho3Lines
from gateway.links.serial.runner import LineRunner
from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, REAL, TEXT
from gateway.pure.controllers.rho3.serial.events import DriverNotStarted, Event, Finished, ProgramAborted
from gateway.pure.controllers.rho3.serial.setup import Assignment, Condition, Function, Procedure, Process, Setup
from hil_tests.rig.serial.conftest import Rig, hear
from protocols.base.machine import Damage
from protocols.p3964r.events import BlockReceived
from protocols.p3964r.events import Event as LinkEvent
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

LineStarter = Callable[..., Rig]
ONE, TWO = Process(1, 100, stop_on_error=False), Process(2, 110, stop_on_error=False)
STOPS = Process(3)
LIMIT_S = 10.0


def setup(protocol: int, *more: Assignment) -> Setup:
    return Setup((Assignment(Function.V24_1, "SER_1", protocol), *more), lines=("SER_1",), panel=None)


@contextlib.asynccontextmanager
async def control(rig: Rig, wanted: Setup) -> AsyncIterator[tuple[Rho3Lines, list[Event]]]:
    told: list[Event] = []
    lines = Rho3Lines(wanted, {"SER_1": rig.url("a")}, lambda event, now: told.append(event))
    try:
        await until(lambda: lines.runners["SER_1"].state.connected)
        async with asyncio.timeout(LIMIT_S):
            yield lines, told
    finally:
        lines.close()


@contextlib.contextmanager
def opened(rig: Rig, side: str) -> Iterator[BytePort]:
    port = rig.port(side)
    try:
        yield port
    finally:
        port.close()


async def until(predicate: Callable[[], bool]) -> None:
    start = time.monotonic()
    while not predicate():
        assert time.monotonic() - start < LIMIT_S, "did not happen in time"
        await asyncio.sleep(0.001)


async def heard(port: BytePort, count: int) -> bytes:
    """So many good characters."""
    items: list[bytes | Damage] = await asyncio.to_thread(hear, port, lambda items: len(items) >= count)
    return b"".join(item for item in items if isinstance(item, bytes))


class Partner:
    """A PLC that speaks 3964R without priority."""

    def __init__(self, rig: Rig) -> None:
        self.blocks: list[bytes] = []
        self.link = Link(PROFILES["rho3"], Priority.LOW)
        self.runner = LineRunner(lambda: rig.port("b"), self.link, lambda event, now: self._note(event))

    def send(self, block: bytes) -> None:
        self.link.send(block, time.monotonic_ns())
        self.runner.kick()

    def _note(self, event: LinkEvent) -> None:
        if isinstance(event, BlockReceived):
            self.blocks.append(event.data)


@contextlib.asynccontextmanager
async def partner(rig: Rig) -> AsyncIterator[Partner]:
    one = Partner(rig)
    try:
        await until(lambda: one.runner.state.connected)
        yield one
    finally:
        one.runner.close()


def test_protocol_2_echoes_over_the_line(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, setup(Procedure.ECHO)) as (lines, _):
            with opened(rig, "b") as port:
                call = asyncio.ensure_future(lines.read(ONE, "V24_1", INTEGER, INTEGER))
                port.write(b"12,-7\r")
                assert await heard(port, 6) == b"12,-7\r"
                assert await asyncio.wait_for(call, 5) == Finished(1, Condition.NO_ERROR, (12, -7))
                assert (await lines.write(ONE, "V24_1", (TEXT, b"done"), (REAL, 1.5))).condition == Condition.NO_ERROR
                assert await heard(port, 12) == b"done     1.5"

    asyncio.run(play(line("--baud", "9600")))


def test_3964r_both_ways_over_the_line(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, setup(Procedure.LINK_3964R)) as (lines, _), partner(rig) as plc:
            assert (await lines.write(ONE, "V24_1", (INTEGER, 258), (CHARACTER, 0x10))).condition == Condition.NO_ERROR
            assert plc.blocks == [b"\x02\x01\x00\x00\x10"]
            plc.send(b"\x01\x00\x00\x00\x02\x00\x00\x00")
            assert await lines.read(ONE, "V24_1", INTEGER) == Finished(2, Condition.NO_ERROR, (1,))
            assert await lines.read(ONE, "V24_1", INTEGER) == Finished(3, Condition.NO_ERROR, (2,))

    asyncio.run(play(line("--baud", "9600")))


def test_a_silent_partner_is_minus_3_and_the_next_write_goes_through(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, setup(Procedure.LINK_3964R)) as (lines, told), partner(rig) as plc:
            rig.control.unplug()
            assert (await lines.write(STOPS, "V24_1", (CHARACTER, 1))).condition == Condition.TIME_OUT
            assert [event for event in told if isinstance(event, ProgramAborted)] == [
                ProgramAborted(STOPS.number, Function.V24_1, Condition.TIME_OUT, "Time out")
            ]
            rig.control.plug()
            assert (await lines.write(ONE, "V24_1", (CHARACTER, 2))).condition == Condition.NO_ERROR
            assert plc.blocks == [b"\x02"]

    asyncio.run(play(line("--baud", "19200")))


def test_a_spoiled_character_is_the_condition_of_the_read(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, setup(Procedure.NO_ECHO)) as (lines, _):
            with opened(rig, "b") as port:
                for kind, condition in (("parity", Condition.PARITY), ("framing", Condition.FRAMING), ("overrun", Condition.OVERRUN)):
                    rig.control.damage("B", kind, 1)
                    call = asyncio.ensure_future(lines.read(ONE, "V24_1", INTEGER))
                    port.write(b"1")
                    assert (await call).condition == condition
                    assert await lines.condition(ONE, "V24_1") == condition

    asyncio.run(play(line("--baud", "9600")))


def test_an_adapter_pulled_out_is_minus_7_and_everything_comes_back_with_it(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, setup(Procedure.NO_ECHO)) as (lines, _):
            call = asyncio.ensure_future(lines.read(ONE, "V24_1", INTEGER))
            await asyncio.sleep(0)
            rig.control.remove("A")
            assert (await call).condition == Condition.INTERFACE
            rig.control.insert("A")
            await until(lambda: lines.runners["SER_1"].state.connected)
            with opened(rig, "b") as port:
                call = asyncio.ensure_future(lines.read(ONE, "V24_1", INTEGER))
                port.write(b"5\r")
                assert (await call).values == (5,)

    asyncio.run(play(line("--baud", "9600")))


def test_a_function_with_another_rate_opens_the_port_anew(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        other = Assignment(Function.V24_2, "SER_1", Procedure.NO_ECHO, "19200 8E1")
        async with control(rig, setup(Procedure.NO_ECHO, other)) as (lines, _):
            first = lines.runners["SER_1"]
            with opened(rig, "b") as port:
                assert (await lines.write(ONE, "V24_2", (TEXT, b"fast"))).condition == Condition.NO_ERROR
                assert await heard(port, 4) == b"fast"
                assert lines.runners["SER_1"] is not first
                assert lines.manager.lines["SER_1"].format == "19200 8E1"
                assert (await lines.write(TWO, "V24_1", (TEXT, b"slow"))).condition == Condition.NO_ERROR
                assert await heard(port, 4) == b"slow"

    asyncio.run(play(line("--baud", "0")))


def test_a_refused_call_ends_at_once_and_a_program_waits_for_room(line: LineStarter) -> None:
    async def play(rig: Rig) -> None:
        async with control(rig, Setup((Assignment(Function.V24_1, "SER_3", 8),), ("SER_1",))) as (lines, told):
            assert (await lines.write(ONE, "V24_1", (CHARACTER, 1))).condition == Condition.NO_INTERFACE
            assert told == [DriverNotStarted(Function.V24_1, Condition.NO_INTERFACE)]
        async with control(rig, setup(Procedure.NO_ECHO)) as (lines, _):
            with opened(rig, "b") as port:
                calls = [asyncio.ensure_future(lines.write(ONE, "V24_1", (CHARACTER, 65 + index))) for index in range(40)]
                assert await heard(port, 40) == bytes(range(65, 105))
                assert {(await call).condition for call in calls} == {Condition.NO_ERROR}

    asyncio.run(play(line("--baud", "38400")))


def test_a_setup_without_its_ports_is_refused() -> None:
    async def play() -> None:
        Rho3Lines(Setup(()), {"SER_1": "pty:/nowhere"})

    with pytest.raises(ValueError, match="SER_2, SER_3, SER_4, PHG"):
        asyncio.run(play())
