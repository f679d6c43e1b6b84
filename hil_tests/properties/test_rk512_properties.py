"""RK512: any block is answered with a reaction or known as one; never an exception."""

from hypothesis import given
from hypothesis import strategies as st

from hil_tests.lab.partners.rk512_active import ActiveStation
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.machine import ms
from protocols.rk512.passive import Dialect, Fetched, Passive, Refused, UnexpectedReaction, Written

HEADERS = st.tuples(
    st.sampled_from([0, 0, 0, 0xFF, 1]), st.sampled_from([0, 0, 1]), st.sampled_from(b"AAEEO\x00Z"), st.sampled_from(b"DDDDXMQ"),
    st.sampled_from([5, 10, 99]), st.integers(0, 255), st.sampled_from([0, 0, 0, 1]), st.integers(0, 70), st.sampled_from([255, 255, 6]),
    st.integers(0, 255),
).map(bytes)  # fmt: skip
TELEGRAMS = st.one_of(st.binary(max_size=138), st.tuples(HEADERS, st.binary(max_size=128)).map(b"".join))
SETTINGS = st.builds(
    Dialect,
    db_address_unit=st.sampled_from(["word", "byte"]),
    reaction=st.booleans(),
    unknown_block=st.integers(1, 255),
    coordination_flag=st.sampled_from(["refuse", "ignore", "serve"]),
    follow_on_reaction=st.booleans(),
)


@given(SETTINGS, st.lists(TELEGRAMS, max_size=10))
def test_any_block_is_answered_or_known_as_a_reaction(settings: Dialect, telegrams: list[bytes]) -> None:
    store = Blocks({5: 100, 10: 64}, locked=(5,))
    passive = Passive(store, settings)
    for telegram in telegrams:
        before = bytes(store.blocks[10])
        (event,) = passive.telegram(telegram, 0)
        reaction = passive.take_output()
        if isinstance(event, UnexpectedReaction) or not settings.reaction:
            assert reaction is None
        else:
            assert reaction is not None and len(reaction) <= 132 and reaction[1:3] == b"\x00\x00"
            assert (reaction[3] == 0) == isinstance(event, Written | Fetched)
        if isinstance(event, Refused):
            assert event.number != 0 and event.why
        assert isinstance(event, Written) or bytes(store.blocks[10]) == before
    assert not any(store.blocks[5])


@given(st.lists(st.tuples(st.binary(max_size=60), st.integers(0, ms(6000))), max_size=15))
def test_the_active_station_survives_any_partner(pieces: list[tuple[bytes, int]]) -> None:
    station, now = ActiveStation(), 0
    station.fetch(10, 0, 1, now)
    station.send(10, 0, b"\x00\x01", now)
    for piece, time in pieces:
        if station.take_output():
            station.sent(now)
        station.receive(piece, now)
        now += time
        station.wake(now)
    station.lost(now)
    assert station.pending == 0
