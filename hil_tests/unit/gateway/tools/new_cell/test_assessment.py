"""Ten answers and what they mean."""

import pytest

from gateway.files.texts import read_texts
from gateway.pure.reports.sentences import in_language
from gateway.tools.new_cell.assessment import ASKED, BadAnswer, Verdict, assess, verdict

GOOD = {
    "control": "rho3", "p15": "3", "axes": "6", "drives": "new", "plc": "rk512", "pic": "no", "baps": "no", "backups": "yes",
    "sister": "yes", "risk": "J. Muster",
}  # fmt: skip


def of(**changes: str) -> dict[str, Verdict]:
    return {reason.key: reason.verdict for reason in assess(GOOD | changes)}


def test_a_cell_that_fits_in_everything_is_a_yes_with_a_reason_for_each_answer() -> None:
    reasons = assess(GOOD)
    assert verdict(reasons) is Verdict.YES
    assert [reason.key for reason in reasons] == [asked.key for asked in ASKED] == list(GOOD)
    assert all(reason.text for reason in reasons)


@pytest.mark.parametrize(
    "key, answer, expected",
    [
        ("control", "reis", Verdict.WITH),
        ("p15", "9", Verdict.WITH),
        ("p15", "3, 5", Verdict.YES),
        ("p15", "-", Verdict.YES),
        ("axes", "12", Verdict.YES),
        ("axes", "13", Verdict.WITH),
        ("axes", "33", Verdict.NO),
        ("drives", "servodyn", Verdict.WITH),
        ("drives", "analog", Verdict.NO),
        ("plc", "bits", Verdict.WITH),
        ("pic", "yes", Verdict.WITH),
        ("baps", "yes", Verdict.WITH),
        ("baps", "positions", Verdict.YES),
        ("backups", "no", Verdict.WITH),
        ("sister", "no", Verdict.WITH),
        ("risk", "nobody", Verdict.NO),
    ],
)
def test_one_answer_decides_its_line_and_the_worst_line_decides_the_whole(key: str, answer: str, expected: Verdict) -> None:
    assert of(**{key: answer})[key] is expected
    assert verdict(assess(GOOD | {key: answer})) is expected


@pytest.mark.parametrize(
    "key, answer, words",
    [
        ("control", "rho4", "one of rho3, reis, val3, other"),
        ("axes", "0", "a number from 1 to 99"),
        ("axes", "six", "a number from 1 to 99"),
        ("p15", "three", "numbers with commas"),
        ("risk", "", "a name, or none is needed"),
        ("plc", "", "(nothing): one of rk512"),
    ],
)
def test_an_answer_that_is_none_is_reported_with_those_there_are(key: str, answer: str, words: str) -> None:
    with pytest.raises(BadAnswer) as found:
        assess(GOOD | {key: answer})
    assert words in str(found.value)


def test_our_words_promise_nothing_we_do_not_hold() -> None:
    """users.md 5: words to avoid."""
    said = " ".join(reason.text for key in ASKED for answer in key.answers for reason in assess(GOOD | {key.key: answer}))
    assert not {"safe", "certified", "drop-in", "guaranteed"} & set(said.lower().split())


def test_every_reason_of_every_answer_has_its_german() -> None:
    texts = read_texts("assess")
    assert all(asked.free or asked.answers for asked in ASKED)
    for key in texts.ids():
        sentence = texts.said(key, "X")
        assert in_language(sentence, "de") == sentence.german and (sentence.german != str(sentence) or key.startswith("a.control."))
    for asked in ASKED:
        for answer in asked.answers:
            assert f"r.{asked.key}.{answer}" in texts.ids()


def test_nothing_is_promised_that_no_cell_can_do() -> None:
    """What cells reach is named as reached: pendants, access levels; what no part does: welding."""
    said = {key: str(read_texts("assess").said(f"r.control.{key}")) for key in ("rho3", "reis", "val3")}
    assert "pendants" in said["rho3"] and "API" not in said["rho3"]
    assert (
        "robot programs, access levels" in said["reis"]
        and "no weld or oscillation" in said["reis"]
        and "moves, alter and user pages" in said["val3"]
    )


def test_programs_are_judged_by_the_control_they_were_written_for() -> None:
    """What runs in a cell is named with the command that checks it; what does not says so."""
    expected = {"rho3": ("axisgate program check", "Intel-hex files"), "reis": ("axisgate robotstar check", "axisgate plc check")}
    expected["val3"] = ("axisgate val3 check", "runs no program of the controller's own PLC")
    for control in ("rho3", "reis", "val3", "other"):
        reasons = {reason.key: reason.text for reason in assess(GOOD | {"control": control, "baps": "yes", "pic": "yes"})}
        baps, pic = expected.get(control, ("neither in a cell", "runs no program of the controller's own PLC"))
        assert baps in reasons["baps"] and pic in reasons["pic"], control
        assert ("run in the cell" in reasons["baps"]) is (control in expected)
