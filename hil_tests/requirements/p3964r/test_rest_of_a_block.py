"""The rest of a torn or misread block never becomes a block of its own (AX-240).

Here a burst matters: what a port hands over at once did not wait for our answer.  So no Bench, which also feeds byte by byte.
"""

import itertools

import pytest

from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Event, Refusal, SendRepeated, StrayCharacters
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, RHO3, Priority, Profile

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
GOOD_AB = b"AB\x10\x03\x10"
TAIL = b"\x02\x41D\x05\x10\x03\x13"  # of a longer block: from its 02h on it looks like a block (41h ^ 44h ^ 05h = 0: the check fits)


class Line:
    """One link; every `hears` is one burst."""

    def __init__(self, profile: Profile = RHO3, priority: Priority = Priority.LOW) -> None:
        self.link, self.now, self.told = Link(profile, priority), 0, list[Event]()
        self.link.take_output()

    def at(self, now: Ns) -> "Line":
        while (due := self.link.deadline()) is not None and due <= now:
            self.told += self.link.wake(due)
        self.now = now
        return self

    def hears(self, burst: bytes) -> "Line":
        self.told += self.link.receive(burst, self.now)
        return self

    def says(self, expected: bytes, leaves: bool = True) -> "Line":
        assert self.link.take_output() == expected
        if expected and leaves:
            self.told += self.link.sent(self.now)
        return self

    def reports(self, *expected: Event) -> "Line":
        assert self.told == list(expected)
        self.told = []
        return self


def torn(profile: Profile = RHO3) -> Line:
    """A block broke off in its data; the silence was answered at 300 ms."""
    line = Line(profile).hears(STX).says(DLE).at(ms(5)).hears(b"AB").at(ms(5) + profile.char_delay).says(NAK)
    return line.reports(BlockRefused(Refusal.GAP, 2))


@pytest.mark.parametrize("name", sorted(PROFILES))
def test_the_rest_of_a_torn_block_that_comes_in_one_burst_is_no_block(name: str) -> None:
    profile = PROFILES[name]
    line, quiet = torn(profile).at(ms(1000)).hears(TAIL).says(b"").reports(), profile.char_delay
    line.at(ms(1000) + quiet - 1).hears(STX).says(b"").reports()  # behind the rest without a pause: may belong to it
    line.at(ms(1000) + 2 * quiet - 2).says(b"").reports()
    line.at(ms(1000) + 2 * quiet - 1).says(DLE).reports(StrayCharacters(len(TAIL)))  # nothing followed: it waits for us (AX-654)
    line.hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_the_rest_of_a_torn_block_that_comes_one_by_one_does_not_wait_for_our_dle() -> None:
    line = torn().at(ms(300)).hears(TAIL[:1]).says(DLE, leaves=False).at(ms(301)).hears(TAIL[1:2])
    line.link.sent(ms(301))
    line.at(ms(302)).hears(TAIL[2:]).says(b"").reports()
    line.at(ms(522)).says(NAK).reports(StrayCharacters(len(TAIL)))  # the partner may have taken our DLE for an answer (AX-1730)
    line.hears(STX).says(DLE).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_after_a_torn_block_a_partner_who_waits_for_our_dle_is_served_at_once() -> None:
    line = torn().at(ms(226)).hears(STX).says(DLE).reports()
    line.at(ms(230)).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))
    line.at(ms(231)).hears(STX + GOOD_AB).says(DLE + DLE).reports(BlockReceived(b"AB"))  # in doubt no longer


def test_a_partner_whose_block_comes_before_a_slow_port_reported_that_our_dle_left_loses_one_attempt() -> None:
    line = torn().at(ms(226)).hears(STX).says(DLE, leaves=False).at(ms(230)).hears(GOOD_AB).says(b"")
    line.at(ms(450)).says(NAK).reports(StrayCharacters(1 + len(GOOD_AB)))  # repeats at once, not after its QVZ (AX-1730)
    line.at(ms(451)).hears(STX).says(DLE, leaves=False)
    line.at(ms(455)).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_what_follows_a_wrong_end_is_no_block() -> None:
    """One of a doubled DLE was hit: the other one made an end in the middle."""
    line = Line().hears(STX).says(DLE).at(ms(5)).hears(b"AB\x10\x03\x00" + TAIL).says(NAK).reports(BlockRefused(Refusal.CHECK, 2))
    line.at(ms(10)).hears(TAIL).says(b"").at(ms(230)).says(b"")
    line.reports(StrayCharacters(len(TAIL)), StrayCharacters(len(TAIL)))


def test_a_lone_stx_among_stray_characters_is_a_wish_one_with_company_is_not() -> None:
    line = Line().hears(b"x").at(ms(1)).hears(STX).says(DLE).hears(GOOD_AB).says(DLE).reports(StrayCharacters(1), BlockReceived(b"AB"))
    line.at(ms(500)).hears(b"x" + STX + GOOD_AB).says(b"").at(ms(720)).reports(StrayCharacters(1), StrayCharacters(6))
    line.at(ms(900)).hears(b"x").at(ms(1120)).hears(STX + GOOD_AB).says(DLE + DLE).reports(StrayCharacters(1), BlockReceived(b"AB"))


def test_a_refused_block_in_one_burst_with_its_stx_gets_nak_alone() -> None:
    """A DLE before the NAK would be taken for the acknowledgement."""
    Line().hears(STX + b"AB\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.CHECK, 2))


@pytest.mark.parametrize("noise", [b"\xa1", b"A\x10", b"A\x10\x10", b"\x10x"])
def test_what_came_in_one_burst_with_the_stx_and_is_no_whole_block_is_not_part_of_the_block(noise: bytes) -> None:
    """A spoiled repeat of STX behind it: without block check nothing else would show it."""
    line = Line(RHO3.plain()).hears(STX + noise).says(DLE).at(ms(2)).hears(GOOD_AB[:-1]).says(DLE).reports(BlockReceived(b"AB"))
    line.at(ms(900)).hears(STX + noise).says(DLE).at(ms(1120)).says(NAK)
    assert isinstance(line.told[-1], BlockRefused)


def test_a_damaged_rest_and_a_lost_port_end_the_doubt() -> None:
    line = torn().at(ms(300)).hears(TAIL)
    line.told += line.link.damaged(Damage.PARITY, ms(300))
    line.told += line.link.lost(ms(300))
    line.says(b"").reports(StrayCharacters(len(TAIL) + 1), BlockRefused(Refusal.LOST, 0))
    line.hears(STX + GOOD_AB).says(DLE + DLE).reports(BlockReceived(b"AB"))


def test_a_sender_that_hears_the_rest_of_a_block_does_not_give_way_to_a_02h_in_it() -> None:
    line = Line()
    line.link.send(b"A", 0)
    line.says(STX).at(ms(1)).hears(b"xy" + TAIL + b"z").says(b"")  # neither an answer nor a wish of ours into the rest
    line.at(ms(221)).says(STX)  # quiet again
    assert [type(event) for event in line.told] == [SendRepeated, StrayCharacters]
    line.at(ms(222)).hears(DLE).says(b"A\x10\x03\x52").hears(DLE)
    assert line.told[-1] == BlockSent(1)


# ---- a wish behind garbage (AX-654)
@pytest.mark.parametrize("garbage", [b"A", b"\x03", b"AB\x15", b"\x10\x10"])
@pytest.mark.parametrize("wishes", [1, 2, 5])
def test_a_wish_in_the_burst_behind_garbage_is_answered_at_once_and_once(garbage: bytes, wishes: int) -> None:
    line = Line().hears(garbage + STX * wishes).says(DLE)
    line.told.clear()
    line.at(ms(5)).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_two_stx_with_more_behind_them_in_one_burst_are_no_wish() -> None:
    line = Line().hears(b"A" + STX + STX + b"B").says(b"").at(ms(220)).says(b"").reports(StrayCharacters(1), StrayCharacters(2))
    line.hears(STX).says(DLE)


def test_a_spoiled_character_behind_a_wish_takes_it_back() -> None:
    line = torn().at(ms(1000)).hears(TAIL).at(ms(1100)).hears(STX)
    line.told += line.link.damaged(Damage.PARITY, ms(1101))
    line.at(ms(1321)).says(b"").reports(StrayCharacters(len(TAIL) + 2))


def test_a_wish_behind_the_end_of_a_block_in_one_burst_is_granted_when_the_line_is_quiet() -> None:
    line = Line().hears(STX).says(DLE).at(ms(5)).hears(GOOD_AB + STX).says(DLE).reports(BlockReceived(b"AB"))
    line.at(ms(225)).says(DLE).at(ms(226)).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_a_partner_that_got_a_nak_at_once_asks_again_by_itself() -> None:
    line = Line(PROFILES["vipa-cp240"]).hears(STX).says(DLE).at(ms(5)).hears(GOOD_AB + STX).says(DLE + NAK)
    line.at(ms(300)).says(b"").reports(BlockReceived(b"AB"), StrayCharacters(1))


LETTERS = (b"A", STX, DLE)
GARBAGE = [b"".join(word) for size in (1, 2, 3) for word in itertools.product(LETTERS, repeat=size)]


@pytest.mark.parametrize("name", ["siemens-cp341", "rho3", "linux"])
@pytest.mark.parametrize("pause", [None, 1, 50, 150, 219, 400])
def test_a_strict_sender_is_served_within_two_seconds_of_any_garbage(name: str, pause: int | None) -> None:
    """Garbage, then at once (None: in the same burst) or later a station that says STX, waits, and repeats after QVZ or NAK only."""
    profile, bad = PROFILES[name], dict[bytes, int]()
    for garbage in GARBAGE:
        line = Line(profile)
        line.hears(garbage + (STX if pause is None else b""))
        line.link.sent(0) if line.link.take_output() else None
        begun = 0
        if pause is not None:
            begun = ms(pause)
            _until(line, begun)
            line.at(begun).hears(STX)
        took = _strict_sender(line, begun, profile.ack_delay)
        if took is None or took > ms(2000):
            bad[garbage] = -1 if took is None else took // ms(1)
    assert not bad


def _until(line: Line, moment: Ns) -> None:
    """What is said meanwhile goes to no one who waits for it."""
    while (due := line.link.deadline()) is not None and due <= moment:
        line.at(due)
        if line.link.take_output():
            line.told += line.link.sent(due)


def _strict_sender(line: Line, begun: Ns, patience: Ns) -> Ns | None:
    """Its STX was said at `begun`; how long until its block is delivered and acknowledged."""
    state, waits = "connect", begun + patience
    while line.now < begun + ms(8000):
        said = line.link.take_output()
        if said:
            line.told += line.link.sent(line.now)
        if said[-1:] == DLE and state == "answer" and any(isinstance(event, BlockReceived) for event in line.told):
            return line.now - begun
        next_due = line.link.deadline()
        now = line.now + ms(1) if said else min(waits, waits if next_due is None else next_due)
        if said[-1:] == DLE and state == "connect":
            state, waits = "answer", now + patience
            line.at(now).hears(GOOD_AB)
        elif said or now >= waits:
            state, waits = "connect", now + patience
            line.at(now).hears(STX)
        else:
            line.at(now)
    return None


@pytest.mark.parametrize("end", [b"\x10\x03", b"\x10\x17"])
def test_a_check_of_02h_at_the_end_of_a_rest_is_no_wish(end: bytes) -> None:
    """A DLE there would acknowledge the torn block."""
    line = torn().at(ms(1000)).hears(STX + b"AC").says(b"").at(ms(1010)).hears(end).at(ms(1012)).hears(STX).says(b"")
    line.at(ms(1232)).says(b"").reports(StrayCharacters(6))


# ---- answers that cross with a wish (AX-1730)
CP341, VIPA = PROFILES["siemens-cp341"], PROFILES["vipa-cp240"]


@pytest.mark.parametrize("profile", [RHO3, CP341, VIPA], ids=lambda profile: profile.name)
def test_a_partner_misled_by_our_dle_hears_nak_when_the_line_is_quiet(profile: Profile) -> None:
    """Its STX crossed with our NAK to the torn block, so it repeats it: the second one comes while our DLE to the first leaves."""
    line = torn(profile).at(ms(306)).hears(STX).says(DLE, leaves=False).at(ms(307)).hears(STX).says(b"")
    line.told += line.link.sent(ms(307))
    line.at(ms(310)).hears(GOOD_AB).says(b"").at(ms(310) + profile.char_delay).says(NAK)
    line.at(ms(540)).hears(STX).says(DLE).at(ms(542)).hears(GOOD_AB).says(DLE)
    assert line.told[-1] == BlockReceived(b"AB")


def test_a_cp_says_nak_once_behind_the_rest_of_a_block_too() -> None:
    line = torn(CP341).at(ms(1000)).hears(b"\x02AC").says(b"").at(ms(1220)).says(NAK).reports(StrayCharacters(3))
    line.at(ms(3000)).says(b"")


def test_stray_characters_in_one_burst_are_answered_with_one_nak() -> None:
    """Each NAK costs a partner that waits for DLE one of its attempts; before our DLE it costs it one for nothing."""
    Line(VIPA).hears(b"ABCDEFGH").says(NAK)
    Line(VIPA).hears(b"ABC" + STX).says(DLE)


def test_a_wish_repeated_for_a_nak_to_stray_characters_is_no_data() -> None:
    line = Line(VIPA).hears(b"A").says(NAK).at(ms(1)).hears(STX).says(DLE, leaves=False).at(ms(2)).hears(STX + STX)
    line.told += line.link.sent(ms(2))
    line.at(ms(3)).hears(GOOD_AB).says(DLE)
    assert line.told[-1] == BlockReceived(b"AB")
