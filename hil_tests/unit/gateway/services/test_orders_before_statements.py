"""The order of a stream reaches the planner before the statements of it, however late one of the processes is (AX-1691).

A statement of a job that the planner does not know is dropped: the arm would stand still in front of moves that were given.
"""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

from gateway.processes.planner import TAKEN, heard
from gateway.pure.image.records.cell import InputImage
from gateway.pure.image.records.interpreter import Channels
from gateway.pure.image.records.planner import SAY_LAYOUT, SAY_SIZE, BlockRecord, ProgramOrder, Say, pack_block, run_record
from gateway.runtime.regions import RingReader, RingWriter, create_ring
from gateway.services.program_host import ProgramHost
from gateway.services.publisher import Publisher

STREAM = run_record(ProgramOrder(7, 0, 1.0, 1.0, 1))
MOVES = [BlockRecord(Say.LINE, 7, "PTP J1=1"), BlockRecord(Say.LINE, 7, "PTP J1=2"), BlockRecord(Say.FINISH, 7)]


class Interrupted(RingReader):
    """Others run between the moment at which it looks for records and the one at which they are handed over."""

    def __init__(self, fd: int, meanwhile: Callable[[], None]) -> None:
        super().__init__(fd, "blocks", SAY_LAYOUT)
        self.meanwhile = meanwhile

    def take(self, limit: int = 64) -> list[tuple[int, bytes]]:
        found = super().take(limit)
        self.meanwhile()
        self.meanwhile = lambda: None
        return found


def rings() -> tuple[int, RingWriter, RingWriter, RingReader]:
    blocks, lines = create_ring("blocks", SAY_SIZE, 256, SAY_LAYOUT), create_ring("lines", SAY_SIZE, 256, SAY_LAYOUT)
    return blocks, RingWriter(blocks, "blocks", SAY_LAYOUT), RingWriter(lines, "lines", SAY_LAYOUT), RingReader(lines, "lines", SAY_LAYOUT)


def test_a_planner_that_is_interrupted_between_its_rings_hears_the_order_first() -> None:
    fd, orders, statements, lines = rings()

    def meanwhile() -> None:
        orders.put(pack_block(STREAM))
        for move in MOVES:
            statements.put(pack_block(move))

    blocks = Interrupted(fd, meanwhile)
    assert [heard(blocks, lines), heard(blocks, lines)] == [[], [STREAM, *MOVES]]
    assert heard(blocks, lines) == []


def test_an_order_behind_many_others_comes_first_too() -> None:
    fd, orders, statements, lines = rings()
    blocks = RingReader(fd, "blocks", SAY_LAYOUT)
    many = [BlockRecord(Say.LINE, 3, f"PTP J1={n}") for n in range(TAKEN)]
    for record in (*many, STREAM):
        orders.put(pack_block(record))
    statements.put(pack_block(MOVES[0]))
    assert [heard(blocks, lines), heard(blocks, lines)] == [many, [STREAM, MOVES[0]]]
    statements.put(pack_block(MOVES[1]))
    assert heard(blocks, lines) == [MOVES[1]] and heard(blocks, None) == []


def test_the_interpreter_hears_of_its_stream_behind_the_planner() -> None:
    said: list[str] = []
    hosted = SimpleNamespace(orders=[{"do": "given", "ticket": 1, "job": 7}], sentences=["words"], step=lambda now: None)
    host = ProgramHost.__new__(ProgramHost)
    host._programs, host._seen = cast(Any, SimpleNamespace(hosted=hosted, seen=Channels)), b""
    host._channels = cast(Any, SimpleNamespace(write=lambda *_: None))
    host._orders = cast(Any, SimpleNamespace(put=lambda _: said.append("interpreter")))
    assert host.after() == ["words"] and said == []
    dispatcher = SimpleNamespace(take_orders=list, take_programs=lambda: [STREAM], take_events=list)
    planner = SimpleNamespace(order=lambda _: said.append("planner"), say=lambda _: None)
    publisher = Publisher.__new__(Publisher)
    publisher._bridge = cast(Any, SimpleNamespace(step=lambda _: None))
    publisher._host = cast(Any, SimpleNamespace(inputs_came=lambda _: None, for_cycle=lambda image: image, pass_on=host.pass_on))
    publisher._image = cast(Any, SimpleNamespace(changed=True, for_cycle=InputImage, statements=[]))
    publisher._dispatcher, publisher._planner = cast(Any, dispatcher), cast(Any, planner)
    publisher._inputs, publisher._written = cast(Any, SimpleNamespace(write=lambda *_: None)), b""
    publisher._orders = cast(Any, SimpleNamespace(put=lambda _: None))
    publisher._run = cast(Any, SimpleNamespace(cell=SimpleNamespace(cell=SimpleNamespace(language="en"))))
    publisher._cell_values = cast(Any, SimpleNamespace(refusals={}))
    publisher.publish()
    assert said == ["planner", "interpreter"] and hosted.orders == []
