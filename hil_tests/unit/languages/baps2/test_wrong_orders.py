"""Orders for files and special functions that cannot be meant: each ends its program, and nothing is lost (L6865-6954, L6756-6800,
L7594-7635)."""

import pytest

from hil_tests.unit.languages.baps2.running import all_of, body, run, short

ROBOT = ";;KINEMATICS : (1 = ROB)\n;;ROB.JC_NAMES = A1, A2\n"


def test_a_file_that_is_open_for_reading_keeps_what_it_has() -> None:
    events = all_of(body("READ_BEGIN F\nWRITE F, 2", "FILE : F"), '[files]\n"F.DAT" = "310d0a"')
    assert short(events, "error") == [(0.0, "error", 214)]
    assert events[-1]["files"] == {"F.DAT": "310d0a"}


@pytest.mark.parametrize("order", ["READ F, I", "READ_BEGIN F"])
def test_a_new_file_that_is_open_for_writing_is_not_read(order: str) -> None:
    events = run(body(f"WRITE_BEGIN F\nWRITE F, 1\n{order}", "FILE : F INTEGER : I"))
    assert short(events, "error") == [(0.0, "error", 1057)]


@pytest.mark.parametrize("kind, letters", [("INTEGER", b"1_0"), ("REAL", b"1_0.5")])
def test_digits_with_an_underscore_are_no_number(kind: str, letters: bytes) -> None:
    events = run(body("READ F, N\nWRITE N", f"FILE : F {kind} : N"), f'[files]\n"F.DAT" = "{letters.hex()}0d0a"')
    assert short(events, "error", "write") == [(0.0, "error", 201)]


@pytest.mark.parametrize("factor", ["0.0", "-1.0"])
def test_poti_modify_takes_a_factor_above_zero(factor: str) -> None:
    text = body(f"SF(1, {factor})", "SPC_FCT : 41 = SF(VALUE INTEGER : K VALUE REAL : V)")
    assert short(run(ROBOT + text), "error") == [(0.0, "error", 218)]


@pytest.mark.parametrize(
    "call, code", [("SF(1, 2, PROBE)", 218), ("SF(1, 1, NORMAL)", 206), ("SF(1, 1, FAST)", 206), ("SF(1, 0, PROBE)", None)]
)
def test_measure_on_takes_an_edge_and_a_probe(call: str, code: int | None) -> None:
    declared = "INPUT : 610 = PROBE, 5 = NORMAL, 611 = FAST SPC_FCT : 43 = SF(VALUE INTEGER : K, E INPUT : I)"
    errors = short(run(ROBOT + body(call, declared)), "error")
    assert errors == ([] if code is None else [(0.0, "error", code)])
