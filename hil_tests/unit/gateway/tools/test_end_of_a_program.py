"""The sentence `axisgate program run` ends with."""

from typing import cast

import pytest

from gateway.cell_file.load import load_cell
from gateway.commands import program_cell
from gateway.commands.program_cell import _rest, _result
from gateway.pure.image.records.cell import Motion
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
    found = _result(cast(ToolClient, Axes()), "PICK", answer, 2.0)
    assert str(found["sentence"]) == f"{said} the axes are at A1 1.500"


class Moving:
    """Of a client the motion alone: what it says next, and the last thing for ever."""

    def __init__(self, *motions: Motion) -> None:
        self.motions = list(motions)
        self.asked = 0

    def ask(self, what: str) -> dict[str, object]:
        assert what == "axes"
        self.asked += 1
        return {"motion": int(self.motions.pop(0) if len(self.motions) > 1 else self.motions[0])}


@pytest.mark.parametrize(
    ("cell", "motions", "asked"),
    [
        ("reis-palletiser", (Motion.RUNNING, Motion.STOPPING, Motion.STOPPED), 3),
        ("rho3-servodyn", (Motion.STOPPING, Motion.STOPPED, Motion.STOPPED, Motion.IDLE), 4),
    ],
)
def test_the_stopped_path_of_a_reis_is_its_rest(
    cell: str, motions: tuple[Motion, ...], asked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing gives it up: the end came 5 s later."""
    monkeypatch.setattr(program_cell, "POLL_S", 0.0)
    client = Moving(*motions)
    _rest(cast(ToolClient, client), load_cell(cell))
    assert client.asked == asked
