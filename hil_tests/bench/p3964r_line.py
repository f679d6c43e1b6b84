"""3964R over real ptys: how close a telegram comes to the pace of its line, and how many blocks the loop carries when the line has no pace.

Each figure is a dict {figure, value, unit, reference, reference_value, ratio, goal, met}.
"""

import asyncio
import contextlib
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator

from drivers.ports.base import BytePort
from drivers.ports.open import open_bytes
from drivers.ports.serial.line_format import Record, parse_record
from drivers.ports.serial.pty import READ_SIZE, PtyPort, set_raw
from gateway.links.serial.runner import LineRunner
from gateway.simulation.line.control import LineControl
from gateway.tools.progress import steps
from hil_tests.lab.partners.pty_master import PtyMaster
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.events import BlockReceived, BlockSent, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.header import ErrorNumber
from protocols.rk512.passive import Passive

Figure = dict[str, object]
BLOCK = bytes(range(128))
BLOCKS_GOAL = 4000.0
PART_BLOCKS = 4000  # blocks of one alternating part
PARTS = 5
RATIO_GOAL = 1.03
BAUD = 9600
CHAR_S = 11 / BAUD
TELEGRAMS = 20
SEND = bytes.fromhex("0000 4144 0A00 0040 FFFF") + bytes(range(128))  # 64 words to DB 10 from DW 0
NO_ERROR = bytes(4)


def blocks_per_s() -> Figure:
    """Both stations in one asyncio loop over one bare pty; in turn the same bytes in the same order by bare system calls."""
    raw, ours, repeated = list[float](), list[float](), 0
    while len(ours) < PARTS:
        bare = raw_exchange(PART_BLOCKS)
        if bare < BLOCKS_GOAL and repeated < 2 * PARTS:
            repeated += 1  # the machine was busy with something else: even bare calls did not get there
            continue
        raw.append(bare)
        ours.append(asyncio.run(linked(PART_BLOCKS)))
    value, reference = statistics.median(ours), statistics.median(raw)
    return {
        "figure": "3964r.blocks_per_s",
        "value": round(value),
        "unit": "blocks/s",
        "reference": f"the same bytes, the same turns, by bare read and write on a pty ({repeated} parts repeated)",
        "reference_value": round(reference),
        "ratio": round(value / reference, 3),
        "goal": f">= {BLOCKS_GOAL:.0f}",
        "met": value >= BLOCKS_GOAL,
    }


def raw_exchange(count: int) -> float:
    """Blocks per second with nobody thinking: STX, DLE, block, DLE."""
    master, slave = os.openpty()
    set_raw(slave)
    wire = wire_block(BLOCK)
    turns = (
        (master, slave, bytes((Char.STX,))),
        (slave, master, bytes((Char.DLE,))),
        (master, slave, wire),
        (slave, master, bytes((Char.DLE,))),
    )
    started = time.monotonic()
    for _ in range(count):
        for writer, reader, data in turns:
            os.write(writer, data)
            heard = 0
            while heard < len(data):
                heard += len(os.read(reader, READ_SIZE))
    duration = time.monotonic() - started
    os.close(master)
    os.close(slave)
    return count / duration


async def linked(count: int) -> float:
    """Blocks per second from station to station; every block is compared."""
    master = PtyMaster()
    slave: BytePort = open_bytes("pty:" + master.path, "0")
    assert isinstance(slave, PtyPort)
    done = asyncio.Event()
    heard = 0
    sender = Link(RHO3, Priority.HIGH)

    def took(event: Event, now: int) -> None:
        nonlocal heard
        if not isinstance(event, BlockReceived) or event.data != BLOCK:
            raise RuntimeError(f"unexpected on a clean line: {event}")
        heard += 1

    left = count

    def sent(event: Event, now: int) -> None:
        nonlocal left
        if not isinstance(event, BlockSent):
            raise RuntimeError(f"unexpected on a clean line: {event}")
        left -= 1
        if left:
            sender.send(BLOCK, now)
            first.kick()
        else:
            done.set()

    first = LineRunner(lambda: master, sender, sent)
    second = LineRunner(lambda: slave, Link(RHO3, Priority.LOW), took)
    while not (first.state.connected and second.state.connected):
        await asyncio.sleep(0.01)
    started = time.monotonic()
    sender.send(BLOCK, time.monotonic_ns())
    first.kick()
    await asyncio.wait_for(done.wait(), 60)
    duration = time.monotonic() - started
    first.close()
    second.close()
    if heard != count:
        raise RuntimeError(f"{heard} of {count} blocks arrived")
    return count / duration


class OneBlock:
    """DB 10 with 64 words."""

    def __init__(self) -> None:
        self.content = bytes(128)

    def has(self, db: int) -> bool:
        return db == 10

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return self.content[2 * word : 2 * (word + words)]

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        self.content = data
        return None


def wire_ratio() -> Figure:
    """SEND of 128 bytes with its reaction at 9600 8E1: time on the line by the line process, against the time its characters need."""
    with tempfile.TemporaryDirectory() as folder, line_process(pathlib.Path(folder)) as record:
        windows = asyncio.run(telegrams())
        time.sleep(0.1)
        found = record()
    duration_s, characters = 0.0, 0
    for start, end in windows:
        runs = found.between(start, end)
        count = sum(len(run.data) for run in runs)
        characters += count
        duration_s += (runs[-1].stamp_ns - runs[0].stamp_ns) / 1e9 + CHAR_S  # the first stamp is the end of the first character
    ratio = duration_s / (characters * CHAR_S)
    return {
        "figure": "3964r.wire_ratio",
        "value": round(ratio, 4),
        "unit": "1",
        "reference": f"{characters} characters of both sides in {TELEGRAMS} telegrams at 11 bits / {BAUD} baud, in s",
        "reference_value": round(characters * CHAR_S, 4),
        "ratio": round(ratio, 4),
        "goal": f"<= {RATIO_GOAL}",
        "met": ratio <= RATIO_GOAL,
    }


@contextlib.contextmanager
def line_process(folder: pathlib.Path) -> Iterator[Callable[[], Record]]:
    """A line process of our own, in a runtime folder of its own; gives a function that reads its record."""
    before = os.environ.get("AXISGATE_RUNTIME")
    os.environ["AXISGATE_RUNTIME"] = str(folder / "run")
    path = folder / "record"
    command = [sys.executable, "-m", "gateway.simulation.line.process", "--name", "bench", "--baud", str(BAUD), "--record", str(path)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise RuntimeError("the line process did not start; its message stands above")

        def record() -> Record:
            with LineControl("bench") as control:
                control.status()
            with path.open(encoding="ascii") as file:
                return parse_record(file)

        yield record
    finally:
        process.terminate()
        process.communicate(timeout=5)
        if before is None:
            del os.environ["AXISGATE_RUNTIME"]
        else:
            os.environ["AXISGATE_RUNTIME"] = before


async def telegrams() -> list[tuple[int, int]]:
    """The moments between which each telegram was on the line; the line is quiet in between."""
    blocks = OneBlock()
    passive, reactions = Passive(blocks), asyncio.Queue[bytes]()
    asking, answering = Link(RHO3, Priority.HIGH), Link(RHO3, Priority.LOW)

    def serve(event: Event, now: int) -> None:
        if isinstance(event, BlockReceived):
            passive.telegram(event.data, now)
            reaction = passive.take_output()
            assert reaction is not None
            answering.send(reaction, now)
            station.kick()

    def collect(event: Event, now: int) -> None:
        if isinstance(event, BlockReceived):
            reactions.put_nowait(event.data)

    format = f"{BAUD} 8E1"
    plc = LineRunner(lambda: open_bytes("pty:" + LineControl.path("bench", "a"), format), asking, collect)
    station = LineRunner(lambda: open_bytes("pty:" + LineControl.path("bench", "b"), format), answering, serve)
    while not (plc.state.connected and station.state.connected):
        await asyncio.sleep(0.01)
    windows = []
    for number in steps("3964r", range(TELEGRAMS)):
        start = time.monotonic_ns()
        asking.send(SEND[:-1] + bytes((number,)), start)
        plc.kick()
        if await asyncio.wait_for(reactions.get(), 5) != NO_ERROR or blocks.content[-1] != number:
            raise RuntimeError("the telegram was not taken")
        await asyncio.sleep(0.03)  # the last acknowledgement leaves
        windows.append((start, time.monotonic_ns()))
    plc.close()
    station.close()
    return windows
