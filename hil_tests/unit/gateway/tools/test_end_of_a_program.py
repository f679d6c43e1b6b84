"""The sentence `axisgate program run` ends with."""

from typing import cast

import pytest

from gateway.commands.program_cell import _told
from gateway.tools.client import ToolClient

UNACKNOWLEDGED = "START is refused: the error is not acknowledged"


class Axes:
    """Of a client nothing but where the axes are."""

    def axes(self) -> list[dict[str, object]]:
        return [{"name": "A1", "actual": 1.5}]


@pytest.mark.parametrize(
    ("how", "code", "text", "said"),
    [
        ("aborted", 0, UNACKNOWLEDGED, f"PICK aborted: PICK: {UNACKNOWLEDGED};"),
        ("aborted", 622, "path error 622", "PICK aborted: PICK: 622 path error 622;"),
        ("ended", 0, "", "PICK ended after 2.00 s;"),
    ],
)
def test_a_message_without_a_number_is_said_too(how: str, code: int, text: str, said: str) -> None:
    answer: dict[str, object] = {"how": how, "code": code, "text": text, "place": "PICK"}
    told = _told(cast(ToolClient, Axes()), "PICK", answer, 2.0)
    assert str(told["sentence"]) == f"{said} the axes stand at A1 1.500"
