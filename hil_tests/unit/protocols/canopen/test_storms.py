"""A storm of emergency messages or heartbeats is bounded and counted; ordinary traffic passes untouched (gateway.pure.buses.storms)."""

from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.buses.storms import MOST, WINDOW, Storms
from protocols.base.machine import Frame, ms

EMCY_5, HEARTBEAT_5, ANSWER_5, SYNC = 0x085, 0x705, 0x585, 0x080


def emcy(n: int) -> Frame:
    return Frame(EMCY_5, n.to_bytes(8, "little"))


def test_what_is_no_report_always_passes_at_once_and_in_order() -> None:
    storms = Storms()
    frames = [Frame(identifier, bytes((n,))) for n in range(100) for identifier in (ANSWER_5, SYNC, 0x185)]
    assert storms.pass_on(frames, 0) == frames


def test_of_a_storm_the_first_pass_the_newest_follows_and_the_rest_is_counted() -> None:
    storms = Storms()
    assert storms.pass_on([emcy(n) for n in range(100)], 0) == [emcy(n) for n in range(MOST)]
    assert storms.pass_on([], WINDOW - 1) == []
    assert storms.pass_on([], WINDOW) == [emcy(99)], "what stands at the end is not lost"
    assert storms.left_out(EMCY_5) == 100 - MOST - 1 and storms.left_out(EMCY_5) == 0
    assert storms.pass_on([emcy(7)], WINDOW) == [emcy(7)]


def test_one_node_in_a_storm_takes_nothing_from_another() -> None:
    storms = Storms()
    storms.pass_on([emcy(n) for n in range(1000)], 0)
    assert storms.pass_on([Frame(0x086, bytes(8)), Frame(HEARTBEAT_5, b"\5")], 1) == [Frame(0x086, bytes(8)), Frame(HEARTBEAT_5, b"\5")]


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(1, 3), st.booleans()), max_size=300))
def test_every_report_is_handed_on_or_counted_and_a_second_never_brings_more_than_its_share(
    steps: list[tuple[int, int, bool]],
) -> None:
    storms, now, came, passed = Storms(), 0, 0, 0
    for pause, node, beat in steps:
        now += ms(pause)
        passed += len(storms.pass_on([Frame((0x700 if beat else 0x080) + node, bytes(8))], now))
        came += 1
    passed += len(storms.pass_on([], now + WINDOW))
    left = sum(storms.left_out(function + node) for function in (0x080, 0x700) for node in (1, 2, 3))
    assert passed + left == came
    assert passed <= 6 * (MOST + 1) * (now // WINDOW + 2)
