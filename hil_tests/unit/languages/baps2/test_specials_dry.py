"""Recorded paths, IO logic and PPO in a dry run (rho 3 releases L4210-4264, L5190-5390; AX-1682)."""

import pytest

from hil_tests.unit.languages.baps2.running import Event, run

HEAD = """;;CONTROL = RHO3
;;KINEMATICS : (1 = ONE, 2 = TWO)
;;ONE.JC_NAMES = A1, A2
;;ONE.WC_NAMES = X, Y
;;TWO.JC_NAMES = B1, BN1
;;TWO.WC_NAMES = Z, BK1
PROGRAM P
SPC_FCT : 1 = IO_LOGIC (VALUE INTEGER : F, K, C VALUE REAL : P, V VALUE INTEGER : T)
SPC_FCT : 2 = PPO (VALUE INTEGER : F, K, C VALUE REAL : P, V VALUE INTEGER : T)
SPC_FCT : 29 = REC_ON (VALUE INTEGER : K, MS VALUE REAL : DIST)
SPC_FCT : 30 = REC_OFF (VALUE INTEGER : K INTEGER : N)
SPC_FCT : 31 = REC_READ (VALUE INTEGER : K, I JC_POINT : J POINT : W)
TWO.BELT : 501 = ALONG
ONE.JC_POINT : @J
ONE.POINT : W
INTEGER : N
;;KINEMATICS = ONE
;;INT = LINEAR
BEGIN
"""
FEED = "block_s = 1.0\np5_ms = 10\n[start]\nONE = [0, 0]\nTWO = [0, 0]\n"


def events(body: str, feed: str = FEED) -> list[Event]:
    return run(f"{HEAD}{body}\nPROGRAM_END\n", feed)


def shown(found: list[Event]) -> list[object]:
    return [each["hex"] for each in found if each["event"] == "write"]


def outs(found: list[Event]) -> list[tuple[object, ...]]:
    return [(each["t"], each["channel"], each["value"]) for each in found if each["event"] == "out"]


def errors(found: list[Event]) -> list[object]:
    return [each["code"] for each in found if each["event"] == "error"]


def text(found: list[Event]) -> str:
    return "".join(bytes.fromhex(str(each)).decode() for each in shown(found))


def test_a_path_is_recorded_at_each_distance_of_a_block_and_not_only_at_its_ends() -> None:
    found = events(
        "REC_ON(1, 1, 20.0)\nMOVE TO (100, 50)\nWAIT 0.1\nREC_OFF(1, N)\nREC_READ(1, 2, @J, W)\nWRITE PHG, N, ' ', @J.A1, ' ', @J.A2"
    )
    numbers = text(found).split()
    assert numbers[0] == "6" and [float(each) for each in numbers[1:]] == pytest.approx([80.0, 40.0]), "0, 20 .. 100; 2 is the last but one"


def test_the_ring_keeps_the_newest_fifty() -> None:
    found = events("REC_ON(1, 1, 1.0)\nMOVE TO (200, 0)\nWAIT 0.1\nREC_OFF(1, N)\nREC_READ(1, N, @J, W)\nWRITE PHG, N, ' ', W.X")
    number, oldest = text(found).split()
    assert number == "50" and float(oldest) == pytest.approx(102.0), "2 mm in each P5"


@pytest.mark.parametrize(("system", "entries"), [(3, "6"), (4, "1"), (1, "1")])
def test_measuring_systems_count_through_all_kinematics_and_then_the_belts(system: int, entries: str) -> None:
    """A1, A2, B1, and the belt of TWO: the third one moves, the fourth stands."""
    found = events(f"REC_ON(2, {system}, 20.0)\nMOVE TWO TO (100, 0)\nWAIT 0.1\nREC_OFF(2, N)\nWRITE PHG, N")
    assert text(found).split() == [entries]


def test_a_measuring_system_no_control_has_is_an_error() -> None:
    assert errors(events("REC_ON(1, 25, 20.0)")) == errors(events("REC_ON(1, 0, 20.0)")) == [91]


def test_io_logic_switches_where_the_coordinate_of_the_next_block_is_at_its_position() -> None:
    found = events("MOVE TO (100, 0)\nIO_LOGIC(2, 1, 1, 40, 1, 0)\nMOVE TO (0, 0)\nWAIT 0.1")
    assert outs(found) == [(1.6, 2, 1)]


def test_a_time_offset_shifts_it() -> None:
    assert outs(events("IO_LOGIC(2, 1, 1, 40, 1, 100)\nMOVE TO (100, 0)\nWAIT 0.1")) == [(0.5, 2, 1)]


def test_the_number_is_free_again_where_it_has_acted_and_in_use_before() -> None:
    again = "IO_LOGIC(2, 1, 1, 40, 1, 0)\nMOVE TO (100, 0)\nIO_LOGIC(2, 1, 1, 60, 0, 0)\nMOVE TO (0, 0)\nWAIT 0.1"
    assert outs(events(again)) == [(0.4, 2, 1), (1.4, 2, 0)]
    found = events("IO_LOGIC(2, 1, 2, 40, 1, 0)\nMOVE TO (100, 0)\nIO_LOGIC(2, 1, 1, 60, 0, 0)\nMOVE TO (0, 0)\nWAIT 0.1")
    assert errors(found) == [216], "its coordinate has not moved"
    assert next(each["line"] for each in found if each["event"] == "error") == 23


def test_a_coordinate_that_stops_short_clears_the_io_and_keeps_the_value_of_a_ppo_until_it_is_reset() -> None:
    body = "IO_LOGIC(2, 1, 1, 140, 1, 0)\nPPO(3, 1, 1, 200, 50, 0)\nMOVE TO (100, 0)\nMOVE TO (100, 50)\nWAIT 0.1\n"
    found = events(f"{body}PPO(-3, 1, 1, 0, 7, 0)")
    warnings = [each["text"] for each in found if each["event"] == "warning"]
    assert warnings == ["PPO/IOL : IPO - STOP"] * 2
    assert outs(found) == [(1.01, 2, 0), (1.01, 3, 25), (2.1, 3, 7)]
    assert errors(events(f"{body}PPO(3, 1, 1, 0, 7, 0)\nMOVE TO (0, 0)")) == [217]


def test_a_ppo_has_its_value_at_the_position_and_a_coordinate_that_is_not_there_is_refused() -> None:
    assert outs(events("PPO(3, 1, 2, 20, 50, 0)\nMOVE TO (0, 40)\nWAIT 0.1")) == [(0.5, 3, 50)]
    assert errors(events("PPO(3, 1, 3, 20, 50, 0)")) == [218]


def test_what_a_program_asked_that_is_over_begins_with_no_other_ones_block() -> None:
    other = f"{HEAD.replace('PROGRAM P', 'PROGRAM Q')}IO_LOGIC(2, 1, 1, 40, 1, 0)\nPROGRAM_END\n"
    text_of = f"{HEAD.replace('ONE.POINT : W', 'ONE.POINT : W EXTERNAL : Q')}START Q\nWAIT 0.1\nMOVE TO (100, 0)\nWAIT 0.1\nPROGRAM_END\n"
    assert outs(run(text_of, FEED, Q=other)) == []
