"""What a shadow finds: a bit that is late, a number off, what counts by itself, what was refused, on a line played in virtual time."""

import pytest

from gateway.pure.arbitration.data_blocks import DataBlock, Slot
from gateway.pure.shadow.addresses import places_of
from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.report import as_html, as_text, report
from protocols.base.machine import Ns, ms
from protocols.base.step5 import Step5Type

BUSY = Slot(11, 0, None, "move.busy", bit=8)
PLACE = Slot(11, 2, Step5Type.KF, "axis.A1.actual", factor=0.1)
LIFE = Slot(11, 3, Step5Type.KF, "cell.life")
BLOCK = DataBlock(11, 4, from_plc=False, slots=(BUSY, PLACE, LIFE))
EVERY = 200  # ms between two answers


def content(busy: bool = False, place: int = 0, life: int = 0, more: int = 0) -> bytes:
    return ((busy << 8) | more).to_bytes(2, "big") + bytes(2) + place.to_bytes(2, "big", signed=True) + life.to_bytes(2, "big")


class Play:
    """Ours changes when told; the old controller answers every 200 ms."""

    def __init__(self) -> None:
        self.comparison = Comparison(slack=ms(10), horizon=ms(2_000))
        self.comparison.declare(11, "DB 11", places_of(BLOCK))

    def ours(self, at: int, data: bytes) -> None:
        self.comparison.ours(11, data, ms(at))

    def theirs(self, at: int, data: bytes, lasted: int = 0) -> None:
        self.comparison.theirs(Answer(11, ms(at), ms(at + lasted), 0, data))

    def found(self, now: Ns = ms(10_000)) -> tuple[dict[str, object], dict[str, dict[str, object]]]:
        """The block, and its differing places by name."""
        self.comparison.settle(now)
        (block,) = as_data(self.comparison, 0, now)
        places = block["places"]
        assert isinstance(places, list)
        return dict(block), {str(place["name"] or place["place"]): place for place in places}


def test_what_is_equal_is_equal_and_every_bit_of_the_block_was_compared() -> None:
    play = Play()
    play.ours(0, content(place=100))
    for at in range(EVERY, 2_001, EVERY):
        play.theirs(at, content(place=100))
    block, places = play.found()
    assert (block["equal_percent"], block["answers"], places) == (100.0, 10, {})
    assert block["time_s"] == 1.8  # the first answer stands for no time
    assert block["compared"] == 5, "the bit, the rest of its word, an undeclared word, the number, the life word"


def test_a_bit_of_ours_that_is_late_is_reported_with_its_time() -> None:
    """The old controller's busy rises at 1000 ms and falls at 2000 ms, both seen at that very moment; ours is late by 40 ms."""
    play = Play()
    for at, busy in ((0, False), (1_040, True), (2_040, False)):
        play.ours(at, content(busy))
    for at in range(EVERY, 3_001, EVERY):
        play.theirs(at, content(busy=1_000 <= at < 2_000))
    block, places = play.found()
    place = places["move.busy"]
    assert (place["later_ms"], place["earlier_ms"], place["never"], place["different"]) == (40.0, 0.0, 0, 2)
    assert place["first"] == {"at_s": 1.0, "there": 1, "here": 0} and place["last_age_s"] == 8.0
    assert block["equal_percent"] == pytest.approx(100 * (1 - 400 / 2_800), abs=0.001) and block["age_s"] == 7.0


def test_what_is_late_by_less_than_ours_is_known_is_equal() -> None:
    play = Play()
    for at, busy in ((0, False), (1_008, True)):
        play.ours(at, content(busy))
    for at in range(EVERY, 3_001, EVERY):
        play.theirs(at, content(busy=at >= 1_000))
    assert play.found()[1] == {}


def test_ours_that_let_go_too_early_is_earlier() -> None:
    play = Play()
    play.ours(0, content(busy=True))
    play.ours(960, content())
    for at in (800, 1_000, 1_200):
        play.theirs(at, content(busy=at <= 1_000))
    _, places = play.found()
    assert (places["move.busy"]["earlier_ms"], places["move.busy"]["later_ms"], places["move.busy"]["different"]) == (40.0, 0.0, 1)


def test_the_time_between_question_and_answer_is_the_old_controls() -> None:
    """It made up its answer somewhere in it: whatever ours held meanwhile is equal."""
    play = Play()
    play.ours(0, content())
    play.ours(1_040, content(busy=True))
    play.theirs(1_000, content(busy=True), lasted=60)
    play.theirs(1_200, content(busy=True), lasted=60)
    _, places = play.found()
    assert places == {}


def test_a_number_on_its_way_is_equal_one_that_ours_never_had_is_not() -> None:
    play = Play()
    for step in range(200):  # 1 count a ms, told every 10 ms
        play.ours(10 * step, content(place=10 * step))
    play.theirs(1_003, content(place=1_003))
    _, places = play.found()
    assert places == {}
    play.theirs(1_500, content(place=1_800))
    play.theirs(1_600, content(place=-500))
    _, places = play.found()
    place = places["axis.A1.actual"]
    assert (place["different"], place["never"]) == (2, 1)
    assert place["later_ms"] == pytest.approx(300, abs=11)
    assert place["largest"] == pytest.approx(211.0, abs=1.5), "mm, not counts"


def test_a_word_nobody_declared_is_compared_too() -> None:
    play = Play()
    play.ours(0, content())
    play.theirs(1_000, content(more=0x40))
    _, places = play.found()
    assert set(places) == {"DW 0, other bits"} and places["DW 0, other bits"]["never"] == 1


def test_what_counts_by_itself_is_asked_only_whether_it_counts() -> None:
    play = Play()
    for n in range(10):
        play.ours(100 * n, content(life=n))
        play.theirs(100 * n + 50, content(life=700 + 3 * n))
    _, places = play.found()
    assert places == {}
    stopped = Play()
    for n in range(10):
        stopped.ours(100 * n, content(life=n))
        stopped.theirs(100 * n + 50, content(life=700))
    _, places = stopped.found()
    assert places["cell.life"]["counts"] == {"there": 0, "here": 9}


def test_a_part_of_a_block_says_nothing_of_the_rest() -> None:
    play = Play()
    play.ours(0, content(busy=True, place=5))
    play.comparison.theirs(Answer(11, ms(500), ms(500), 4, content(place=9)[4:6]))
    _, places = play.found()
    assert set(places) == {"axis.A1.actual"}


def test_nothing_is_judged_before_ours_exists_or_the_horizon_has_passed() -> None:
    play = Play()
    play.theirs(100, content(busy=True))
    play.ours(500, content())
    play.theirs(600, content())
    play.comparison.settle(ms(2_500))
    assert not as_data(play.comparison, 0, ms(2_500))
    play.comparison.finish()
    (block,) = as_data(play.comparison, 0, ms(2_500))
    assert block["answers"] == 1


def test_report_says_it_in_words_in_text_and_page() -> None:
    play = Play()
    play.ours(0, content())
    play.ours(1_040, content(busy=True))
    for at in range(EVERY, 3_001, EVERY):
        play.theirs(at, content(busy=at >= 1_000))
    block, _ = play.found()
    line = {
        "line": "plc",
        "connected": True,
        "characters": 9,
        "telegrams": {"heard": 3, "answered": 3, "other_number": 0},
        "blocks": [block],
    }
    found = report(
        {"cell": "Hall <3>", "file": "c.toml"}, {"heard_s": 3.0, "lines": [line]}, {}, ["modbus plc2: neither served nor written"]
    )
    assert (found["equal"], found["differences"], found["compared"]) == (False, 1, True)
    words = as_text(found)
    assert "DB 11: equal in 92.86 % of 2.8 s, 15 times received" in words
    assert "D 0.8 move.busy: equal in 92.86 %, differs by 40 ms (axisgate later), first after 1.000 s: there 1, here 0" in words
    assert "left out: modbus plc2" in words
    page = as_html(found)
    assert "Shadow of Hall &lt;3&gt;" in page and "differs by 40 ms" in page and "<3>" not in page
    equal = report({"cell": "x", "file": "y"}, {"lines": [{**line, "blocks": [{**block, "places": [], "equal_percent": 100.0}]}]}, {}, [])
    assert equal["equal"] is True
    other = report({"cell": "x", "file": "y"}, {"lines": [{**line, "blocks": [], "telegrams": {"other_number": 1}}]}, {}, [])
    assert (other["equal"], other["compared"]) == (False, False) and "nothing was compared" in as_text(other)
