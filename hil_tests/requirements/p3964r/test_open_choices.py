"""What manuals leave open and stations do differently: each choice is a field of the profile (serial-protocols 1.3 to 1.6)."""

from dataclasses import fields, replace

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.errors import EncodeError
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import check_of, wire_block
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
from protocols.p3964r.profiles import (
    LINUX,
    PROFILES,
    RHO3,
    SIEMENS_CP340,
    SIEMENS_CP341,
    VIPA_21X,
    VIPA_CP240,
    WAGO,
    BrokenPair,
    Interruption,
    Priority,
    Profile,
    TooLong,
    least_char_delay,
    profile_named,
)

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
BLOCK_A, BLOCK_B = b"A\x10\x03\x52", b"B\x10\x03\x51"
TIMES = {  # serial-protocols 1.5: name -> QVZ 3964R, QVZ 3964, ZVZ, BWZ in ms, connection attempts, block attempts; None: [open]
    "rho3": (550, None, 220, 4000, 6, 6),
    "siemens-cp341": (2000, 550, 220, 4000, 6, 6),
    "siemens-cp440": (2000, 550, 220, 4000, 6, 6),
    "siemens-cp340": (2000, 550, 220, 4000, 6, 6),
    "siemens-cp524": (2000, 550, 220, 4000, 6, 6),
    "siemens-cp525": (2000, 550, 220, 4000, 6, 6),
    "bosch-buep64": (2000, 550, None, 4000, None, None),
    "vipa-cp240": (500, 500, 200, 2000, 3, 6),
    "vipa-21x": (2000, 500, 200, 10000, 3, 6),
    "wago": (2000, 2000, 220, None, None, 6),
    "beckhoff": (2000, 2000, 220, 4000, None, None),
    "rexroth-vcp": (None, None, None, None, 3, 6),
    "euchner-hbas": (500, 500, 128, None, 3, 3),
    "linux": (550, 550, 220, 4000, 6, 6),
}


@pytest.mark.parametrize("name", TIMES)
def test_times_and_attempts_of_the_table(name: str) -> None:
    profile = PROFILES[name]
    found = (profile.ack_delay, profile.ack_delay_plain, profile.char_delay, profile.block_wait)
    counted = tuple(time // ms(1) for time in found) + (profile.connect_attempts, profile.block_attempts)
    assert all(wanted in (None, value) for wanted, value in zip(TIMES[name], counted, strict=True))


def test_every_open_field_is_one() -> None:
    names = {field.name for field in fields(Profile)}
    assert all(set(profile.open_fields) <= names for profile in PROFILES.values())


def holding(profile: Profile) -> Bench[Link]:
    """Somebody else has the buffer; the partner wishes to send at 0."""
    line = Bench(Link(profile, Priority.LOW)).does(lambda link, now: link.set_buffer_free(False, now))
    for twin in (NAK,) if profile.nak_at_start else ():
        line.says(twin)
    return line.hears(STX).says(b"")


@pytest.mark.parametrize("free_at, answer_at", [(0, 0), (1, 50), (50, 50), (120, 150), (399, 400)])
def test_siemens_looks_for_a_buffer_every_50_ms(free_at: int, answer_at: int) -> None:
    line = holding(SIEMENS_CP341).at(ms(free_at)).does(lambda link, now: link.set_buffer_free(True, now))
    if answer_at > free_at:
        line.at(ms(answer_at) - 1).says(b"")
    line.at(ms(answer_at)).says(DLE)
    line.hears(BLOCK_A).says(DLE).reports(BlockReceived(b"A"))


def test_siemens_a_buffer_that_was_free_between_two_looks_is_not_seen() -> None:
    line = holding(SIEMENS_CP340).at(ms(60)).does(lambda link, now: link.set_buffer_free(True, now))
    line.at(ms(80)).does(lambda link, now: link.set_buffer_free(False, now))
    line.at(ms(400) - 1).says(b"").reports().at(ms(400)).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0))


def test_linux_waits_400_ms_for_a_buffer_and_sees_it_at_once() -> None:
    holding(LINUX).at(ms(399)).does(lambda link, now: link.set_buffer_free(True, now)).says(DLE)


def test_vipa_says_nak_at_once_without_a_buffer_and_to_stray_characters() -> None:
    line = Bench(Link(VIPA_CP240, Priority.LOW)).does(lambda link, now: link.set_buffer_free(False, now))
    line.hears(STX).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0)).hears(b"A").says(NAK)


@pytest.mark.parametrize("profile", [LINUX, WAGO])
def test_stray_characters_are_silent(profile: Profile) -> None:
    Bench(Link(profile, Priority.LOW)).hears(b"A").damaged(Damage.PARITY).at(ms(5000)).says(b"").reports(StrayCharacters(2))


# ---- DLE followed by something else
def test_a_broken_pair_is_noted_and_answered_at_the_end() -> None:
    Bench(Link(RHO3, Priority.LOW)).hears(STX).says(DLE).hears(b"A\x10B\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.ORDER, 1))


def test_a_broken_pair_answered_at_once_leaves_a_tail_of_strays() -> None:
    line = Bench(Link(replace(RHO3, broken_pair=BrokenPair.NAK_AT_ONCE), Priority.LOW)).hears(STX).says(DLE)
    line.hears(b"A\x10BC\x10\x03\x00").says(NAK)
    line.reports(BlockRefused(Refusal.ORDER, 1)).at(ms(300)).reports(StrayCharacters(4))


def test_a_lone_dle_may_be_left_out() -> None:
    line = Bench(Link(replace(RHO3, broken_pair=BrokenPair.DROP_DLE), Priority.LOW)).hears(STX).says(DLE)
    line.hears(b"A\x10B\x10\x03").hears(bytes((0x41 ^ 0x10 ^ 0x42 ^ 0x10 ^ 0x03,))).says(DLE).reports(BlockReceived(b"AB"))


# ---- longer than a block may be
def test_a_block_too_long_answered_at_once() -> None:
    line = Bench(Link(replace(RHO3, too_long=TooLong.NAK_AT_ONCE), Priority.LOW)).hears(STX).says(DLE)
    line.hears(bytes(138)).says(b"").hears(b"\x00").says(NAK).reports(BlockRefused(Refusal.LENGTH, 139)).hears(b"AB").at(ms(500)).reports(
        StrayCharacters(2)
    )


def test_a_block_too_long_with_a_pair_as_the_last_straw() -> None:
    line = Bench(Link(replace(RHO3, too_long=TooLong.NAK_AT_ONCE), Priority.LOW)).hears(STX).says(DLE)
    line.hears(bytes(138) + b"\x10").says(b"").hears(b"\x10").says(NAK).reports(BlockRefused(Refusal.LENGTH, 139))


# ---- the sender
def wishing(profile: Profile, priority: Priority = Priority.HIGH) -> Bench[Link]:
    return Bench(Link(profile, priority), leaves_at_once=False).does(lambda link, now: link.send(b"A", now)).says(STX).left()


def test_wago_gives_up_when_nobody_answers_its_stx() -> None:
    line = wishing(WAGO).at(ms(2000) - 1).says(b"").at(ms(2000)).says(NAK).reports(SendFailed(1, Failure.SILENT, Stage.CONNECT))
    line.at(ms(9000)).says(b"")


def test_wago_repeats_where_the_answer_was_nak() -> None:
    wishing(WAGO).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))


def test_linux_interrupted_in_the_block_waits_for_quiet_and_starts_again() -> None:
    line = wishing(LINUX).hears(DLE).says(BLOCK_A).at(ms(1)).hears(b"x").at(ms(100)).hears(b"y").at(ms(320) - 1).says(b"").reports()
    line.at(ms(320)).says(NAK + STX).reports(SendRepeated(1, Failure.WRONG, Stage.BLOCK))


def test_others_go_on_when_interrupted_in_the_block() -> None:
    assert RHO3.interruption is Interruption.IGNORE
    wishing(RHO3).hears(DLE).says(BLOCK_A).hears(b"x").left().hears(DLE).reports(BlockSent(1))


def test_linux_interrupted_until_all_attempts_are_used_up() -> None:
    line = wishing(LINUX)
    for turn in range(6):
        line.at(ms(300 * turn)).hears(DLE).says(BLOCK_A).hears(b"x").at(ms(300 * turn + 220)).says(NAK + (NAK if turn == 5 else STX)).left()
    assert line.told()[-1] == SendFailed(1, Failure.WRONG, Stage.BLOCK)


def test_a_break_while_backing_off_ends_the_job() -> None:
    wishing(LINUX).hears(DLE).says(BLOCK_A).hears(b"x").damaged(Damage.BREAK).reports(SendFailed(1, Failure.BREAK, Stage.BLOCK))


def test_linux_with_priority_receives_in_a_second_conflict() -> None:
    line = wishing(LINUX).at(ms(1)).hears(STX + STX).says(b"").at(ms(550)).says(STX).left()
    assert isinstance(line.told()[-1], SendRepeated)
    line.at(ms(551)).hears(STX).says(DLE).hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B")).left()
    line.at(ms(560)).hears(STX).says(b"")  # a new start: the first conflict again


@pytest.mark.parametrize("answer", [NAK, b"x"])
def test_linux_with_priority_receives_in_the_first_conflict_of_a_repeat(answer: bytes) -> None:
    """Its discipline looks at the number of repeats, not of conflicts."""
    line = wishing(LINUX).at(ms(1)).hears(answer).says(STX).left().at(ms(2)).hears(STX).says(DLE)
    assert line.told() == [SendRepeated(1, Failure.NAK if answer == NAK else Failure.WRONG, Stage.CONNECT)]
    line.hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))


def test_linux_with_priority_receives_in_a_conflict_after_a_refused_block() -> None:
    line = wishing(LINUX).at(ms(1)).hears(DLE).says(BLOCK_A).hears(NAK).says(STX).left().at(ms(2)).hears(STX).says(DLE)
    assert line.told() == [SendRepeated(1, Failure.NAK, Stage.BLOCK)]
    line.hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))


def test_linux_takes_4000_characters_and_sends_256() -> None:
    for size, answer in ((4000, DLE), (4001, NAK)):
        line = Bench(Link(LINUX, Priority.LOW)).hears(STX).says(DLE).hears(wire_block(bytes(size))).says(answer)
        assert isinstance(line.told()[0], BlockReceived) is (answer == DLE)
    with pytest.raises(EncodeError, match="block of 257 bytes, limit 256"):
        Link(LINUX, Priority.LOW).send(bytes(257), 0)


def test_linux_drops_a_lone_dle_and_takes_what_follows() -> None:
    body = b"A\x10BC\x10\x03"
    line = Bench(Link(LINUX, Priority.LOW)).hears(STX).says(DLE).hears(body + bytes((check_of(body),))).says(DLE)
    line.reports(BlockReceived(b"ABC"))


def test_others_with_priority_never_receive_in_a_conflict() -> None:
    line = wishing(RHO3).at(ms(1)).hears(STX).at(ms(550)).says(STX).left().at(ms(551)).hears(STX).says(b"")
    assert line.told()


# ---- 3964, networks, settings
def test_procedure_3964_has_its_own_acknowledgement_delay_and_no_check() -> None:
    plain = profile_named("siemens-cp341", block_check=False)
    assert plain.name == "siemens-cp341-3964" and not plain.block_check
    line = Bench(Link(plain, Priority.LOW)).says(NAK).does(lambda link, now: link.send(b"A", now)).says(STX)
    line.at(ms(550) - 1).says(b"").at(ms(550)).says(STX)
    line.at(ms(551)).hears(DLE).says(b"A\x10\x03").hears(DLE)
    assert line.told()[-1] == BlockSent(1)


def test_behind_a_network_every_wait_for_the_partner_is_longer() -> None:
    far: Profile = profile_named("vipa-cp240-tcp")
    assert (far.ack_delay, far.char_delay) == (ms(1000), ms(700)) and far.name == "vipa-cp240-tcp"
    line = Bench(Link(far, Priority.LOW)).hears(STX).says(DLE).at(ms(699)).hears(BLOCK_A).says(DLE).reports(BlockReceived(b"A"))
    line.hears(b"A").says(b"")  # a NAK would come late, into the partner's next block


@pytest.mark.parametrize("early_by, taken", [(ms(499), True), (ms(501), False)])
def test_behind_a_network_an_answer_may_be_here_before_the_server_reported_that_the_block_left(early_by: Ns, taken: bool) -> None:
    line = wishing(profile_named("rho3-tcp")).hears(DLE).says(BLOCK_A).hears(DLE).at(early_by).left()
    line.reports(*([BlockSent(1)] if taken else []))


def test_an_unknown_name_is_a_key_error() -> None:
    with pytest.raises(KeyError, match="siemens"):
        profile_named("siemens-tcp")


def test_least_character_delay_by_speed() -> None:
    assert [least_char_delay(baud) // ms(1) for baud in (300, 600, 1200, 2400, 9600)] == [60, 40, 30, 20, 20]


def test_priority_defaults_differ() -> None:
    assert VIPA_21X.priority is LINUX.priority is Priority.HIGH and VIPA_CP240.priority is WAGO.priority is Priority.LOW
