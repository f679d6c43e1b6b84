"""Two 3964R stations (rho3 profile) over the line process at 9600 8E1: the record of the third process is the witness."""

import asyncio
import contextlib
import itertools
import pathlib
import time
from collections.abc import AsyncIterator, Callable
from functools import partial

from drivers.ports.serial.line_format import Run
from gateway.links.serial.runner import LineRunner
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.rig.serial.conftest import Rig, pace_ns
from protocols.base.machine import Ns
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Event, Failure, Refusal, SendFailed, SendRepeated, Stage
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

LineStarter = Callable[..., Rig]
STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
CHAR_NS = 11_000_000_000 / 9600
BLOCK = bytes(range(128))  # holds a DLE
RECOVERY_NS = 2_000_000_000
VECTORS = pathlib.Path(__file__).parents[2] / "vectors" / "3964r_block_check.txt"  # number; payload; wire; once


class Station:
    """A link on one side of the line and what it reported, with moments."""

    def __init__(self, rig: Rig, side: str, priority: Priority) -> None:
        self.link = Link(PROFILES["rho3"], priority)
        self.events: list[tuple[Ns, Event]] = []
        self.runner = LineRunner(lambda: rig.port(side), self.link, lambda event, now: self.events.append((now, event)))

    def send(self, block: bytes) -> None:
        self.link.send(block, time.monotonic_ns())
        self.runner.kick()

    def told(self, kind: type[Event]) -> list[Event]:
        return [event for _, event in self.events if isinstance(event, kind)]

    @property
    def blocks(self) -> list[bytes]:
        return [event.data for _, event in self.events if isinstance(event, BlockReceived)]


@contextlib.asynccontextmanager
async def pair(rig: Rig) -> AsyncIterator[tuple[Station, Station]]:
    """Side A with high, side B with low priority."""
    a, b = Station(rig, "a", Priority.HIGH), Station(rig, "b", Priority.LOW)
    try:
        await until(lambda: a.runner.state.connected and b.runner.state.connected)
        yield a, b
    except AssertionError:
        for station in (a, b):
            print(station.events, station.runner.state, station.link.deadline(), time.monotonic_ns())
        print(*rig.record().notes, *rig.record().runs, sep="\n")
        raise
    finally:
        a.runner.close()
        b.runner.close()


async def until(predicate: Callable[[], bool], limit_s: float = 8.0) -> None:
    start = time.monotonic()
    while not predicate():
        assert time.monotonic() - start < limit_s, "did not happen in time"
        await asyncio.sleep(0.001)


def lost_stx(rig: Rig) -> list[Run]:
    """Attempts to connect that vanished at the break."""
    return [run for run in rig.record().runs if run.mark == "lost" and run.data == STX]


def test_a_block_each_way(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with pair(rig) as (a, b):
            a.send(BLOCK)
            await until(lambda: b.blocks == [BLOCK] and bool(a.told(BlockSent)))
            b.send(BLOCK[::-1])
            await until(lambda: a.blocks == [BLOCK[::-1]] and bool(b.told(BlockSent)))

    asyncio.run(play())
    record = rig.record()
    wire = BLOCK.replace(DLE, DLE + DLE) + b"\x10\x03"
    check = 0
    for byte in wire:
        check ^= byte
    assert record.sent_by("A") == STX + wire + bytes((check,)) + DLE + DLE
    assert record.sent_by("B")[:3] == DLE + DLE + STX
    assert record.characters() == 2 * (len(wire) + 4)
    assert abs(pace_ns(record.stamps("A")[1 : len(wire) + 2]) / CHAR_NS - 1) < 0.01, "the block runs without gaps"


def test_the_twelve_vectors_cross_the_line_in_their_written_form(line: LineStarter) -> None:
    """Payload FF stands doubled on a pty (PARMRK form); the record has it as it was on the line."""
    rig = line("--baud", "9600")
    vectors = [tuple(map(bytes.fromhex, row.split(";")[1:3])) for row in VECTORS.read_text().splitlines() if row and row[0] != "#"]
    payloads = [payload for payload, _ in vectors]

    async def cross(sender: Station, hearer: Station) -> None:
        for payload in payloads:
            sender.send(payload)
        await until(lambda: hearer.blocks == payloads and len(sender.told(BlockSent)) == 12, 20)

    async def play() -> None:
        async with pair(rig) as (a, b):
            await cross(a, b)
            await cross(b, a)

    asyncio.run(play())
    record = rig.record()
    assert len(vectors) == 12
    for side in "AB":
        assert b"".join(STX + wire for _, wire in vectors) in record.sent_by(side)


def test_both_at_once_and_both_arrive(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with pair(rig) as (a, b):

            def arrived(count: int) -> bool:
                return all(len(one.blocks) == len(one.told(BlockSent)) == count for one in (a, b))

            for index in range(3):
                a.send(b"high%d" % index)
                b.send(b"low%d" % index)
                await until(partial(arrived, index + 1))
            assert b.blocks == [b"high0", b"high1", b"high2"]
            assert a.blocks == [b"low0", b"low1", b"low2"]
            assert not a.told(SendFailed)
            assert not b.told(SendFailed)

    asyncio.run(play())
    runs = rig.record().runs
    stamps = [next(run.stamp_ns for run in runs if run.side == side and run.data == STX) for side in "AB"]
    assert abs(stamps[0] - stamps[1]) < 2 * CHAR_NS, "the first wishes to send did meet"


def test_a_damaged_character_costs_one_repeat_and_the_block_comes_once(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with pair(rig) as (a, b):
            rig.control.damage("A", "parity", 40)
            a.send(BLOCK)
            await until(lambda: b.blocks == [BLOCK] and bool(a.told(BlockSent)))
            (refused,) = b.told(BlockRefused)
            assert isinstance(refused, BlockRefused)
            assert refused.why is Refusal.DAMAGED
            (repeated,) = a.told(SendRepeated)
            assert isinstance(repeated, SendRepeated)
            assert (repeated.why, repeated.stage) == (Failure.NAK, Stage.BLOCK)

    asyncio.run(play())
    assert rig.record().sent_by("B") == DLE + NAK + DLE + DLE
    assert [run.mark for run in rig.record().runs if run.mark] == ["parity"]


def test_repeats_are_seen_while_unplugged_and_the_block_is_over_within_2_s_of_plugging(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> tuple[Ns, Ns]:
        async with pair(rig) as (a, b):
            rig.control.unplug()
            a.send(BLOCK)
            await until(lambda: len(lost_stx(rig)) >= 3)
            plugged = rig.control.plug()
            await until(lambda: b.blocks == [BLOCK])
            assert not a.told(SendFailed)
            return plugged, next(now for now, event in b.events if isinstance(event, BlockReceived))

    plugged, received = asyncio.run(play())
    assert received - plugged <= RECOVERY_NS
    stamps = [run.stamp_ns for run in lost_stx(rig)]
    gaps_ms = [(later - earlier) / 1e6 for earlier, later in itertools.pairwise(stamps)]
    assert all(abs(gap - 551.146) <= 20 for gap in gaps_ms), f"550 ms after the STX has left, and its own time: {gaps_ms}"


def test_a_break_inside_a_block_is_repaired_within_2_s_of_plugging(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> tuple[Ns, Ns]:
        async with pair(rig) as (a, b):
            a.send(BLOCK)
            await until(lambda: b.runner.state.counters.received > 40)
            rig.control.unplug()
            await until(lambda: bool(a.told(SendRepeated)))
            plugged = rig.control.plug()
            await until(lambda: b.blocks == [BLOCK])
            return plugged, b.events[-1][0]

    plugged, received = asyncio.run(play())
    assert received - plugged <= RECOVERY_NS


def test_after_giving_up_the_next_job_needs_no_help(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with pair(rig) as (a, b):
            rig.control.unplug()
            a.send(b"in vain")
            await until(lambda: bool(a.told(SendFailed)))
            rig.control.plug()
            start = time.monotonic()
            a.send(b"heard")
            await until(lambda: b.blocks == [b"heard"])
            assert time.monotonic() - start < 0.5

    asyncio.run(play())
    assert len(lost_stx(rig)) == 6, "the first attempt and five repeats"


def test_a_pulled_adapter_fails_the_job_and_the_next_is_over_within_2_s_of_its_return(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with pair(rig) as (a, b):
            a.send(BLOCK)
            await until(lambda: b.runner.state.counters.received > 10)
            rig.control.remove("A")
            await until(lambda: bool(a.told(SendFailed)))
            (failed,) = a.told(SendFailed)
            assert isinstance(failed, SendFailed)
            assert failed.why is Failure.LOST
            await until(lambda: bool(b.told(BlockRefused)))
            inserted = rig.control.insert("A")
            a.send(b"again")
            await until(lambda: b.blocks == [b"again"])
            assert b.events[-1][0] - inserted <= RECOVERY_NS

    asyncio.run(play())


def test_a_noisy_line_delivers_every_block_in_order(line: LineStarter) -> None:
    rig = line("--baud", "115200")

    async def play() -> None:
        async with pair(rig) as (a, b):
            rig.control.damage_some("A", "parity", 0.004, seed=3)
            rig.control.damage_some("B", "parity", 0.02, seed=4)
            blocks = [bytes((index,)) * 60 for index in range(30)]
            for block in blocks:
                a.send(block)
            await until(lambda: len(a.told(BlockSent)) + len(a.told(SendFailed)) == len(blocks), 30)
            assert a.told(SendFailed) == []
            unique = [block for index, block in enumerate(b.blocks) if index == 0 or b.blocks[index - 1] != block]
            assert unique == blocks, "a repeat of an acknowledged block is legal, a loss or a wrong order is not"
            assert a.told(SendRepeated)

    asyncio.run(play())


def test_the_threaded_loop_speaks_with_the_asyncio_loop(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        b = Station(rig, "b", Priority.LOW)

        def plc() -> bool:
            link = Link(PROFILES["rho3"], Priority.HIGH)
            with SyncLine(lambda: rig.port("a"), link) as a:
                link.send(BLOCK, time.monotonic_ns())
                return a.run_until(lambda: any(isinstance(event, BlockSent) for _, event in a.events), 5)

        assert await asyncio.to_thread(plc)
        assert b.blocks == [BLOCK]
        b.runner.close()

    asyncio.run(play())
