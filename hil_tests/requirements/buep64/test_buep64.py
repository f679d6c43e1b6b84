"""BUEP64: limits, times, ends, own faults (Bosch R500 interface manual 1070 072 131-102, chapter 9)."""

import pytest

from gateway.assembly.line_dialects import rk512_dialect
from gateway.pure.cell.cell import Line, Rk512
from gateway.pure.lines.buep64 import buep64_dialect, buep64_fault
from gateway.pure.lines.line_profiles import link_profile
from gateway.pure.lines.rk512_link import Rk512Link
from hil_tests.lab.virtual.bench import Bench
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.errors import EncodeError
from protocols.base.machine import ms
from protocols.buep64.faults import REDUCED_LENGTH, Cause, fault_of
from protocols.buep64.form import Form, Plc, reaction_wait
from protocols.p3964r.characters import wire_block
from protocols.p3964r.profiles import Priority
from protocols.rk512.active import Active, Denied, Done, Failed, Trouble
from protocols.rk512.passive import Continued, Fetched

STX, DLE = b"\x02", b"\x10"
LINE = Line("rst", "sim", profile="bosch-buep64", layer="buep64", rk512=Rk512(end_of_follow_on="ETB"))


def station() -> Bench[Rk512Link]:
    blocks = Blocks({5: 300})
    return Bench(Rk512Link(link_profile(LINE), Priority.LOW, blocks, rk512_dialect(LINE), 9600))


def test_times_by_speed() -> None:
    assert [reaction_wait(baud) // ms(1000) for baud in (110, 150, 300, 600, 1200, 19200)] == [20, 15, 10, 7, 5, 5]
    assert [buep64_dialect(Form()).waits(baud) for baud in (110, 19200)] == [ms(20_000), ms(5_000)]


def test_limits_of_a_job() -> None:
    form = Form()
    assert form.fault_of_job(255, 255, 256) is None and Form(Plc.CL300).fault_of_job(0, 127, 1) is None
    assert form.fault_of_job(256, 0, 1) == fault_of(Cause.DM_NUMBER)
    assert Form(Plc.CL300).fault_of_job(0, 128, 1) == fault_of(Cause.PARTNER_ADDRESS)
    assert form.fault_of_job(0, 0, 257) == form.fault_of_job(0, 0, 0) == fault_of(Cause.AMOUNT)
    with pytest.raises(EncodeError, match=r"514 bytes, range 2\.\.512"):
        Active(buep64_dialect(form)).fetch(0, 257, 5)


@pytest.mark.parametrize(
    "event, shown",
    [
        (Failed(1, Trouble.NO_REACTION), "34/F7 time monitoring"),
        (Failed(1, Trouble.LINK), "34/F9 attempts exceeded"),
        (Failed(1, Trouble.COMMAND_INSTEAD), "34/FE line opening: character other than STX"),
        (Failed(1, Trouble.FIRST_BYTE), "34/FF nothing interpretable received"),
        (Failed(1, Trouble.TOO_MUCH_DATA), "33/F3 amount wrong"),
        (Denied(1, 0x14), "33/ED wrong partner DM number"),
        (Denied(1, 0x36), "34/FF nothing interpretable received"),
    ],
)
def test_what_a_bosch_plc_shows(event: Failed | Denied, shown: str) -> None:
    assert str(buep64_fault(event)) == shown and REDUCED_LENGTH == 0x20


def test_completion_sequences_end_with_etb_where_it_is_switched() -> None:
    line = station().hears(STX + wire_block(bytes.fromhex("00004544050000 41FFFF"))).says(DLE + DLE + STX).reports(Fetched(5, 0, 65))
    line.at(1000).hears(DLE).says(wire_block(bytes(4 + 128))).hears(DLE)
    line.hears(STX + wire_block(b"\xff\x00\x45\x44")).says(DLE + DLE + STX).reports(Continued(0))
    line.at(2000).hears(DLE).says(bytes.fromhex("FF 00 00 00 00 00 10 17 F8")).hears(DLE).reports()


def test_a_request_instead_of_the_response_ends_the_own_job_and_is_served() -> None:
    line = station().does(_fetch).says(STX).hears(DLE).says(wire_block(bytes.fromhex("00004544070000 01FFFF"))).hears(DLE)
    line.at(1000).hears(STX + wire_block(bytes.fromhex("00004544050000 01FFFF"))).says(DLE + DLE + STX)
    line.reports(Failed(1, Trouble.COMMAND_INSTEAD), Fetched(5, 0, 1))


def test_with_nesting_the_request_is_served_and_the_job_goes_on() -> None:
    line = Bench(Rk512Link(link_profile(LINE), Priority.LOW, Blocks({5: 300}))).does(_fetch).says(STX).hears(DLE)
    line.says(wire_block(bytes.fromhex("00004544070000 01FFFF"))).hears(DLE)
    line.at(1000).hears(STX + wire_block(bytes.fromhex("00004544050000 01FFFF"))).says(DLE + DLE + STX).reports(Fetched(5, 0, 1))
    line.at(2000).hears(DLE).says(wire_block(bytes(6))).hears(DLE)
    line.hears(STX + wire_block(b"\x00\x00\x00\x00AB")).says(DLE + DLE).reports(Done(1, b"AB"))


def _fetch(machine: Rk512Link, now: int) -> None:
    machine.active.fetch(0, 1, 7)
    machine.start(now)
