"""The twelve vectors of hil_tests/vectors/3964r_block_check.txt, in both directions."""

from pathlib import Path

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import ms
from protocols.p3964r.characters import wire_block
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Refusal
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
FILE = Path(__file__).parents[2] / "vectors" / "3964r_block_check.txt"
LINES = [line.split(";") for line in FILE.read_text().splitlines() if line and not line.startswith("#")]
VECTORS = [pytest.param(*(bytes.fromhex(part) for part in parts), id=number) for number, *parts in LINES]


def test_there_are_twelve() -> None:
    assert len(VECTORS) == 12


@pytest.mark.parametrize("payload, wire, once", VECTORS)
@pytest.mark.requirement("RHO-SER-03", "RHO-SER-04", by="protocols.p3964r.characters:wire_block")
def test_sent(payload: bytes, wire: bytes, once: bytes) -> None:
    line = Bench(Link(RHO3, Priority.LOW)).does(lambda link, now: link.send(payload, now)).says(STX)
    line.at(ms(1)).hears(DLE).says(wire).at(ms(300)).hears(DLE).reports(BlockSent(1))
    assert wire_block(payload) == wire


@pytest.mark.parametrize("payload, wire, once", VECTORS)
@pytest.mark.requirement("RHO-SER-03", "RHO-SER-04", by="protocols.p3964r.receiver:Receiver._deliver")
def test_received(payload: bytes, wire: bytes, once: bytes) -> None:
    Bench(Link(RHO3, Priority.LOW)).hears(STX).says(DLE).hears(wire).says(DLE).reports(BlockReceived(payload))


@pytest.mark.parametrize("payload, wire, once", VECTORS)
@pytest.mark.requirement("RHO-SER-09", by="protocols.p3964r.receiver:Receiver._refuse")
def test_a_check_that_counts_a_doubled_dle_once_is_good_only_by_chance(payload: bytes, wire: bytes, once: bytes) -> None:
    line = Bench(Link(RHO3, Priority.LOW)).hears(STX).says(DLE).hears(wire[:-1] + bytes((wire[-1] ^ 0x10,)))
    line.says(NAK).reports(BlockRefused(Refusal.CHECK, len(payload)))
    odd = payload.count(DLE) % 2 == 1
    assert (once != wire[-1:]) == odd
