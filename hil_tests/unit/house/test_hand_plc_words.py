"""What the tutorial's PLC program prints of a move whose outcome it never received."""

from hil_tests.lab.partners.hand_plc import unfinished
from hil_tests.lab.partners.plc1 import Block


def test_a_move_without_an_outcome_is_not_called_refused() -> None:
    words = unfinished(Block(bytes(4) + (4923).to_bytes(2, "big") + bytes(58)))
    assert "did not end" in words and "4923 (KF, 0.1 mm)" in words and "on" in words
    assert "refused" not in words and "error" not in words
