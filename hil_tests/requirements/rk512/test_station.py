"""Both RK512 roles on one link: whose block is it, what leaves first, and the link's repeats (AX-225)."""

from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.rk512.active import Active, Done, Failed, Trouble, Unasked
from protocols.rk512.dialects import STANDARD, Dialect
from protocols.rk512.passive import Continued, Fetched, Passive, Refused
from protocols.rk512.station import Repeated, Station

FETCH = bytes.fromhex("00004544050000 01FFFF")


def station(dialect: Dialect = STANDARD) -> Station:
    return Station(Passive(Blocks({5: 8}), dialect), Active(dialect), dialect)


def test_a_command_heard_twice_is_answered_once() -> None:
    both = station()
    assert both.block(FETCH, 0) == [Fetched(5, 0, 1)] and both.take_block() == bytes(6)
    assert both.block(FETCH, 0) == [Repeated(FETCH)] and both.take_block() is None
    assert both.block_sent(0) == [] and both.block(FETCH, 0) == [Fetched(5, 0, 1)]


def test_a_reaction_the_link_gave_up_is_given_again() -> None:
    both = station()
    both.block(FETCH, 0)
    assert both.take_block() is not None and both.block_failed(0) == []
    assert both.block(FETCH, 0) == [Fetched(5, 0, 1)]


def test_without_reactions_every_telegram_counts() -> None:
    both = station(Dialect(reaction=False))
    for _ in range(2):
        assert both.block(FETCH, 0) == [Fetched(5, 0, 1)] and both.take_block() is None


def test_a_reaction_goes_before_a_command_and_each_outcome_finds_its_own() -> None:
    both = station()
    both.active.fetch(0, 1, 7)
    both.block(FETCH, 0)
    assert both.take_block() == bytes(6) and (both.take_block() or b"")[4] == 7 and both.take_block() is None
    assert both.block_sent(0) == [] and not both.active.awaiting
    assert both.block_failed(0) == [Failed(1, Trouble.LINK)]


def test_garbage_instead_of_a_reaction_is_named() -> None:
    for garbage, why in ((b"\x00", Trouble.TOO_SHORT), (b"\x05\x00\x41\x00", Trouble.FIRST_BYTE)):
        both = station()
        both.active.fetch(0, 1, 7)
        both.take_block()
        both.block_sent(0)
        assert both.block(garbage, 0) == [Failed(1, why)]


def test_a_reaction_the_partner_wished_to_send_before_it_had_our_command_is_not_its_answer() -> None:
    """The repeat of the reaction before, whose acknowledgement got lost: right form, wrong job (AX-242)."""
    both = station()
    both.active.fetch(0, 1, 7)
    both.take_block()
    both.block_sent(0)
    assert both.block(bytes(4) + b"\x00\x01", 0, overtaken=True) == [Unasked(bytes(5) + b"\x01")] and both.active.awaiting
    assert both.block(bytes(4) + b"\x00\x02", 0) == [Done(1, b"\x00\x02")]
    assert both.block(FETCH, 0, overtaken=True) == [Fetched(5, 0, 1)]  # a command of his own is served all the same


def test_nothing_awaited_and_a_lost_port() -> None:
    both = station()
    assert both.block(bytes(4), 0) == [Unasked(bytes(4))]
    both.active.fetch(0, 1, 7)
    both.take_block()
    assert both.lost() == [Failed(1, Trouble.LOST)] and both.take_block() is None


OTHER = bytes.fromhex("00004544050100 01FFFF")
LONG = bytes.fromhex("00004544050000 41FFFF")


def test_a_new_command_withdraws_the_reaction_under_way() -> None:
    """AX-650: the link puts the newer reaction in the place of the older one, whose outcome is never told."""
    both = station()
    both.block(FETCH, 0)
    assert both.take_block() is not None and both.reactions == 1
    assert both.block(OTHER, 0) == [Fetched(5, 1, 1)] and both.take_block() == bytes(6) and both.reactions == 2
    both.replaced()
    assert both.reactions == 1 and both.block_sent(0) == [] and both.reactions == 0


def test_a_first_telegram_after_an_untaken_reaction_begins_anew_and_a_follow_on_goes_on() -> None:
    for given_up in (False, True):
        for data, event in ((FETCH, Fetched(5, 0, 1)), (bytes.fromhex("FF004544"), Continued(0))):
            both = Station(Passive(Blocks({5: 65})), Active(), STANDARD)
            both.block(LONG, 0)
            assert both.take_block() is not None
            if given_up:
                both.block_failed(0)
            assert both.block(data, 0) == [event]


def test_a_first_telegram_after_a_reaction_that_was_taken_is_out_of_sequence() -> None:
    both = Station(Passive(Blocks({5: 65})), Active(), STANDARD)
    both.block(LONG, 0)
    both.take_block()
    both.block_sent(0)
    (refused,) = both.block(FETCH, 0)
    assert isinstance(refused, Refused) and refused.number == 0x36
