"""A whole RK512 conversation in virtual time: a PLC's active station, 3964R at 9600 Bd, our link and our passive station."""

import pytest

from hil_tests.lab.partners.rk512_active import ActiveStation, Done, Failed, Refused, Trouble, reaction_time
from hil_tests.lab.virtual.rk512_blocks import Blocks
from hil_tests.lab.virtual.virtual_line import NO_FAULTS, Faults, VirtualLine
from protocols.base.errors import EncodeError
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.passive import Dialect, Passive

CHAR = 11_000_000_000 // 9600


class Cell:
    """PLC on the left, gateway's side on the right."""

    def __init__(self, settings: Dialect | None = None, seed: int = 0, faults: Faults = NO_FAULTS) -> None:
        self.plc, self.link = ActiveStation(), Link(RHO3, Priority.LOW)
        self.blocks = Blocks({10: 64, 11: 64})
        self.passive = Passive(self.blocks, settings)
        self.results: list[tuple[Ns, object]] = []
        self.line = VirtualLine[object](self.plc, self.link, self._note, seed, faults)

    def _note(self, side: int, event: object, now: Ns) -> None:
        if side == 0:
            self.results.append((now, event))
        elif isinstance(event, BlockReceived):
            self.passive.telegram(event.data, now)
            reaction = self.passive.take_output()
            if reaction is not None:
                self.link.send(reaction, now)
                self.line.kick(1)

    def wait(self, time: Ns) -> list[object]:
        self.line.kick(0)
        self.line.run(self.line.now + time)
        results, self.results = self.results, []
        return [event for _, event in results]


def test_send_then_fetch() -> None:
    cell, data = Cell(), bytes(range(128))
    cell.plc.send(10, 0, data, 0)
    cell.plc.fetch(10, 60, 4, 0)
    cell.plc.fetch(12, 0, 1, 0)
    assert cell.wait(ms(1000)) == [Done(1, b""), Done(2, data[120:]), Refused(3, 0x14)]
    assert cell.plc.pending == 0


def test_a_full_send_takes_its_characters_and_nothing_more() -> None:
    cell = Cell()
    cell.plc.send(10, 0, bytes(range(1, 129)), 0)  # one 10h in it
    cell.line.kick(0)
    cell.line.run(ms(500))
    wire = 1 + 1 + (10 + 128 + 1 + 3) + 1 + 1 + 1 + (4 + 3) + 1  # STX DLE block DLE, STX DLE reaction DLE
    moment, event = cell.results[0]
    assert event == Done(1, b"") and moment == (wire - 1) * CHAR  # the last DLE is the PLC's own


def test_no_reaction_in_time() -> None:
    cell = Cell(Dialect(reaction=False))
    cell.plc.send(10, 0, b"\x00\x01", 0)
    assert cell.wait(ms(5000)) == []
    assert cell.wait(ms(50)) == [Failed(1, Trouble.NO_REACTION)]
    assert cell.blocks.blocks[10][:2] == b"\x00\x01"


def test_waiting_times_by_speed() -> None:
    assert [reaction_time(baud) // ms(1) for baud in (300, 600, 1200, 9600, 19200, 38400)] == [10000, 7000, 5000, 5000, 5000, 3000]


def test_a_partner_that_is_away_and_comes_back() -> None:
    plc, link = ActiveStation(), Link(RHO3, Priority.LOW)
    results: list[object] = []
    deaf = VirtualLine[object](plc, link, lambda side, event, now: results.append(event) if side == 0 else None, 0, Faults(drop=1.0))
    plc.send(10, 0, b"\x00\x01", 0)
    deaf.kick(0)
    deaf.run(ms(13_000))
    assert results == [Failed(1, Trouble.LINK)] and plc.counts["SendRepeated"] == 5


def test_lost_port_ends_all_jobs() -> None:
    plc = ActiveStation()
    plc.send(10, 0, b"\x00\x01", 0)
    plc.fetch(10, 0, 1, 0)
    assert plc.lost(ms(1)) == [Failed(1, Trouble.LOST), Failed(2, Trouble.LOST)] and plc.pending == 0


@pytest.mark.parametrize("data", [b"", b"\x00", bytes(3), bytes(130)])
def test_the_active_station_sends_no_impossible_amount(data: bytes) -> None:
    with pytest.raises(EncodeError):
        ActiveStation().send(10, 0, data, 0)


@pytest.mark.parametrize("seed", range(3))
def test_on_a_damaged_line_every_job_has_a_result_and_what_was_taken_is_there(seed: int) -> None:
    cell = Cell(seed=seed, faults=Faults(damage=0.003))
    for number in range(30):
        data = bytes((number, 0x10, 0x03, number))
        cell.plc.send(10, number, data, cell.line.now)
        cell.plc.fetch(10, number, 2, cell.line.now)
        # The reaction to a repeated command (its acknowledgement was damaged) comes twice; the second is nobody's
        results = [event for event in cell.wait(ms(60_000)) if isinstance(event, Done | Refused | Failed)]
        assert len(results) == 2 and cell.plc.pending == 0
        if results[0] == Done(2 * number + 1, b""):
            assert cell.blocks.blocks[10][2 * number : 2 * number + 4] == data
    assert cell.plc.counts["SendRepeated"] > 0
