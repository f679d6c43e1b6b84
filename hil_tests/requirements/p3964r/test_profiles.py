"""Stations other than the rho 3: the same machine with another profile (sources: protocols.p3964r.profiles)."""

from dataclasses import replace

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import ms
from protocols.p3964r.characters import Char
from protocols.p3964r.events import (
    BlockReceived,
    BlockRefused,
    BlockSent,
    Failure,
    Refusal,
    SendFailed,
    SendRepeated,
    Stage,
    StrayCharacters,
)
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, RHO3, SIEMENS_CP341, ConnectCounter, Priority, Profile, Stray

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
BLOCK_A = b"A\x10\x03\x52"


def wishing(profile: Profile) -> Bench[Link]:
    return Bench(Link(profile, Priority.HIGH)).says(b"").does(lambda link, now: link.send(b"A", now)).says(STX)


def test_the_profiles_of_this_release() -> None:
    siemens = {f"siemens-cp{number}" for number in (340, 341, 440, 524, 525)}
    bosch = {"rho3", "bosch-buep64", "bosch-system350-rk512", "bosch-system350-3964r", "rexroth-vcp"}
    others = {"vipa-cp240", "vipa-21x", "wago", "beckhoff", "linux", "euchner-hbas", "aeg-fx22z"}
    assert set(PROFILES) == siemens | bosch | others
    assert all(profile.name == name and profile.source for name, profile in PROFILES.items())


def test_cp341_says_nak_once_at_start_and_again_when_the_port_comes_back() -> None:
    line = Bench(Link(SIEMENS_CP341, Priority.LOW)).says(NAK).at(ms(9000)).says(b"")
    line.loses_the_port().says(NAK)


def test_cp341_answers_stray_characters_once_after_the_line_was_quiet() -> None:
    line = Bench(Link(SIEMENS_CP341, Priority.LOW)).says(NAK).hears(b"AB").at(ms(100)).hears(b"C")
    line.at(ms(320) - 1).says(b"").reports()
    line.at(ms(320)).says(NAK).reports(StrayCharacters(3)).at(ms(9000)).says(b"")


def test_cp341_waits_2_s_for_an_answer() -> None:
    line = Bench(Link(SIEMENS_CP341, Priority.LOW)).says(NAK).does(lambda link, now: link.send(b"A", now)).says(STX)
    line.at(ms(2000) - 1).says(b"").at(ms(2000)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.CONNECT))


def test_nak_at_once_to_stray_characters() -> None:
    Bench(Link(replace(RHO3, stray=Stray.NAK_AT_ONCE), Priority.LOW)).hears(b"A").says(NAK).hears(NAK).says(b"")


def test_nak_at_once_without_a_buffer() -> None:
    line = Bench(Link(replace(RHO3, no_buffer_wait=0), Priority.LOW)).does(lambda link, now: link.set_buffer_free(False, now))
    line.hears(STX).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0))


def test_without_block_check_the_end_is_the_end() -> None:
    plain = replace(RHO3, block_check=False)
    Bench(Link(plain, Priority.LOW)).hears(STX + b"A\x10\x03").says(DLE + DLE).reports(BlockReceived(b"A"))
    wishing(plain).hears(DLE).says(b"A\x10\x03").hears(DLE).reports(BlockSent(1))


def test_etb_is_sent_where_the_partner_wants_it() -> None:
    wishing(replace(RHO3, end=Char.ETB)).hears(DLE).says(b"A\x10\x17\x46")


def test_a_fresh_set_of_connection_attempts_for_every_block_attempt() -> None:
    line = wishing(replace(RHO3, connect_counter=ConnectCounter.PER_BLOCK)).hears_apart(NAK * 5).says(STX * 5)
    line.at(ms(1)).hears(DLE).says(BLOCK_A).hears_apart(NAK).says(STX).hears_apart(NAK * 5).says(STX * 5)
    line.at(ms(2)).hears(NAK).says(NAK)
    assert line.told()[-1] == SendFailed(1, Failure.NAK, Stage.CONNECT)


def test_one_counter_for_both_kinds_of_attempts() -> None:
    line = wishing(replace(RHO3, connect_counter=ConnectCounter.SHARED)).hears_apart(NAK * 3).says(STX * 3)
    line.hears(DLE).says(BLOCK_A).hears_apart(NAK).says(STX).hears(DLE).says(BLOCK_A).hears_apart(NAK).says(STX)
    line.hears(NAK).says(NAK)
    assert line.told()[-1] == SendFailed(1, Failure.NAK, Stage.CONNECT)


def test_a_pause_before_a_repeat_in_which_the_partner_may_send() -> None:
    line = wishing(replace(RHO3, retry_pause=ms(50))).at(ms(1)).hears(NAK).says(b"").reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))
    line.at(ms(51)).says(STX).hears(NAK).says(b"").hears(b"x").says(b"")
    line.at(ms(60)).hears(STX).says(DLE).hears(b"B\x10\x03\x51").says(DLE + STX)
    line.reports(SendRepeated(1, Failure.NAK, Stage.CONNECT), BlockReceived(b"B"))


def test_no_nak_when_giving_up() -> None:
    line = wishing(replace(RHO3, nak_when_giving_up=False)).hears_apart(NAK * 5).says(STX * 5).hears(NAK).says(b"")
    line.reports(*[SendRepeated(1, Failure.NAK, Stage.CONNECT)] * 5, SendFailed(1, Failure.NAK, Stage.CONNECT))


@pytest.mark.parametrize("name", list(PROFILES))
def test_every_profile_carries_a_block_both_ways(name: str) -> None:
    greeting = NAK if PROFILES[name].nak_at_start else b""
    line = Bench(Link(PROFILES[name], Priority.LOW)).says(greeting).does(lambda link, now: link.send(b"A", now)).says(STX)
    line.hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))
    line.hears(STX + BLOCK_A).says(DLE + DLE).reports(BlockReceived(b"A"))
