"""Minutes 3 and 6 of docs/guide/tutorial.md: a person for the PLC's program, and numbers that are refused."""

import contextlib
import pathlib

import pytest

from hil_tests.lab.partners.hand_plc import HELP, Hand
from hil_tests.lab.running.cell_running import running_cell

PAGE = pathlib.Path(__file__).resolve().parents[3] / "docs" / "guide" / "tutorial.md"


MACHINE = (
    "error 16;",
    "error 17;",
    "error 18;",
    "error 20;",
    "error 22;",
    "error 26;",
    "error 27;",
    "error 44;",
)  # what a busy machine does to drives
SPARE = 8
MOVE_S = 30.0  # obey gives a move up after that; as long again for getting ready
pytestmark = pytest.mark.timeout(60.0 + 2 * SPARE * MOVE_S)


@pytest.fixture(scope="module")
def answers() -> dict[str, str]:
    """What was typed, and what stood there then."""
    with running_cell("demo", "hand", plc=False) as run:
        hand = Hand(run.name, run.port)
        try:
            begun = hand.begin()
            found = {wish: typed(hand, wish) for wish in ("1200", "help", "20000", "kg")}
        finally:
            hand.end()
    return {"begin": begun, **found}


def typed(hand: Hand, wish: str) -> str:
    """Once more where the machine, not the gateway, ended it."""
    for _ in range(SPARE):
        try:
            answer = hand.obey(wish)
        except TimeoutError as error:
            answer = str(error)
        else:
            if not any(word in answer for word in MACHINE):
                return answer
        with contextlib.suppress(TimeoutError):
            hand.ready()
    return answer


def test_a_person_moves_an_axis_over_the_line(answers: dict[str, str]) -> None:
    assert answers["begin"] == "drives on, referenced"
    assert answers["1200"] == "done; A1 is at 1200 (KF, 0.1 mm)" and answers["1200"] in PAGE.read_text()
    assert answers["help"] == HELP


def test_wrong_numbers_are_refused_with_the_error_the_page_shows(answers: dict[str, str]) -> None:
    assert answers["20000"] == "refused or ended, error 4 (target outside the limits); A1 is at 1200 (KF, 0.1 mm)"
    assert answers["kg"] == "refused or ended, error 5 (number format); A1 is at 1200 (KF, 0.1 mm)" and answers["kg"] in PAGE.read_text()
