"""Ctrl-C at `axisgate program run`: a stop that was refused or lost is ordered again, and the command ends with the program."""

from gateway.commands import program_cell
from gateway.commands.program_cell import _stopped
from gateway.tools.client import ToolClient, ToolError


class Deaf(ToolClient):
    """The cell loses the first orders; it refuses one of them."""

    def __init__(self, lost: int) -> None:
        self.lost, self.stops = lost, 0

    def ask(self, op: str, **request: object) -> dict[str, object]:
        if request["do"] == "stop":
            self.stops += 1
            if self.stops == 1:
                raise ToolError("no such process")
            return {"ok": True}
        return {"over": self.stops > self.lost, "rows": []}


def test_a_stop_that_stopped_nothing_is_ordered_again() -> None:
    client = Deaf(lost=2)
    before, program_cell.STOP_AGAIN_S = program_cell.STOP_AGAIN_S, 0.0
    try:
        assert _stopped(client, 7, "LOOP")["over"] and client.stops == 3
    finally:
        program_cell.STOP_AGAIN_S = before
