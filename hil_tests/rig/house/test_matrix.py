"""Coverage matrix and mutants over a small folder of sample tests, by real pytest runs."""

import json
import pathlib
import subprocess
import sys

import pytest

from hil_tests.matrix import coverage, record, verdicts
from hil_tests.matrix.catalogue import ROOT, rows
from hil_tests.matrix.mutant_plugin import Hang, drawn, judged, time_limit
from hil_tests.matrix.record import Result
from hil_tests.matrix.verdicts import Pair, Trial, matrix

SAMPLE = """
import pytest
from protocols.base.machine import ms
BY = "protocols.base.machine:ms"

@pytest.mark.requirement("RHO-SER-01", by=BY)
def test_that_turns_everything_into_an_assertion():
    try:
        value = ms(1)
    except Exception as error:
        value = error
    assert value == 1_000_000

@pytest.mark.requirement("RHO-SER-02", by=BY)
def test_that_only_calls():
    ms(1)

@pytest.mark.requirement("RHO-SER-03", by=BY)
def test_through_which_the_exception_merely_runs():
    assert ms(1) == 1_000_000

@pytest.mark.requirement("RHO-SER-04", by=BY)
def test_with_raises():
    with pytest.raises(TypeError):
        ms(None)

@pytest.mark.requirement("RHO-SER-05", by=BY)
def test_with_raises_too_wide():
    with pytest.raises(Exception):
        ms(None)

@pytest.mark.requirement("RHO-SER-06", by=BY)
@pytest.mark.parametrize("count", [0, 2])
def test_of_two_parameters_one_of_which_notices(count):
    try:
        value = ms(count)
    except Exception as error:
        value = 0 if count == 0 else error
    assert value == count * 1_000_000

@pytest.mark.requirement("RHO-SER-07", by=BY)
def test_that_fails():
    assert ms(1) == 1

@pytest.mark.requirement("RHO-SER-08", by=BY)
def test_that_is_skipped():
    pytest.skip("today not")

@pytest.mark.requirement("RHO-NONE-99", by=BY)
def test_with_a_mark_of_no_row():
    pass

def test_without_a_mark():
    assert True
"""

OF_PARAMETERS = """
import pytest
from protocols.base.machine import ms
BY = "protocols.base.machine:ms"

@pytest.mark.requirement("RHO-SER-03", by=BY)
@pytest.mark.parametrize("count", [
    pytest.param(1, marks=pytest.mark.requirement("RHO-SER-01", by=BY)),
    pytest.param(2, marks=pytest.mark.requirement("RHO-SER-02", by=BY)),
])
def test_of_two_parameters_with_a_row_each(count):
    assert ms(count) == 1_000_000
"""


PLUG_IN = ("-p", "hil_tests.matrix.mutant_plugin", "-p", "no:timeout")


@pytest.fixture
def folder(tmp_path: pathlib.Path) -> pathlib.Path:
    (tmp_path / "test_sample.py").write_text(SAMPLE)
    (tmp_path / "conftest.py").write_text("from hil_tests.conftest import pytest_addoption, pytest_configure\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    requirement\n    vcan\n    mbpoll\n    cref\n")
    return tmp_path


def run_pytest(folder: pathlib.Path, *options: str) -> list[dict[str, object]]:
    result = folder / "result.json"
    command = [sys.executable, "-m", "pytest", str(folder), f"--rootdir={folder}", "-q", "-p", "no:cacheprovider", "-m", "requirement"]
    done = subprocess.run([*command, *options, str(result)], cwd=folder, capture_output=True, text=True, check=False)
    assert result.exists(), done.stdout + done.stderr
    found = json.loads(result.read_text())
    lines: list[dict[str, object]] = found["results"] if "--matrix" in options else found
    return lines


def test_mutants_are_judged_by_how_each_test_fails(folder: pathlib.Path) -> None:
    pairs = run_pytest(folder, *PLUG_IN, "--mutants")
    judgement = {str(pair["test"]).partition("::")[2]: (pair["raise"], pair["return"]) for pair in pairs}
    not_run = "not run: sound test: killed"
    assert judgement == {
        "test_that_turns_everything_into_an_assertion": ("killed", "killed"),
        "test_that_only_calls": ("crash", "alive"),
        "test_through_which_the_exception_merely_runs": ("crash", "killed"),
        "test_with_raises": ("killed", "killed"),
        "test_with_raises_too_wide": ("alive", "killed"),
        "test_of_two_parameters_one_of_which_notices": ("killed", "killed"),
        "test_that_fails": (not_run, not_run),
        "test_that_is_skipped": ("not run: sound test: skipped",) * 2,
    }
    small = {str(pair["test"]).partition("::")[2]: [trial["verdict"] for trial in trials_of(pair)] for pair in pairs}
    assert small["test_through_which_the_exception_merely_runs"] == ["killed"], "it needs no second one"
    assert small["test_with_raises"] == small["test_that_only_calls"] == ["alive", "alive"], "though the whole body was missed"


def test_small_changes_are_tried_and_a_crash_of_the_whole_does_not_count_for_or_against(folder: pathlib.Path) -> None:
    pairs = {str(pair["test"]).partition("::")[2]: pair for pair in run_pytest(folder, *PLUG_IN, "--mutants-every", "--mutants")}
    small = {name: {str(trial["words"]): trial["verdict"] for trial in trials_of(pair)} for name, pair in pairs.items()}
    times, number = "value * 1000000 -> value / 1000000", "1000000 -> 1000001"  # two: this folder is none of pure tests
    assert small["test_through_which_the_exception_merely_runs"] == {times: "killed", number: "killed"}
    assert small["test_that_only_calls"] == {times: "alive", number: "alive"}
    assert small["test_with_raises"] == {times: "alive", number: "alive"}


def test_a_sample_is_drawn_by_its_seed() -> None:
    every = {(f"test_{number}", "m:f") for number in range(8)}
    assert drawn(every, "3:7") == drawn(sorted(every, reverse=True), "3:7") and len(drawn(every, "3:7")) == 3
    assert len({frozenset(drawn(every, f"2:{seed}")) for seed in range(3)}) > 1
    assert drawn(every, "100:1") == every, "no more than there are"


def test_only_pairs_of_the_sample_are_run(folder: pathlib.Path) -> None:
    found = [str(pair["test"]) for pair in run_pytest(folder, *PLUG_IN, "--mutants-sample", "2:7", "--mutants")]
    assert len(found) == 2 and {name.partition("::")[0] for name in found} == {"test_sample.py"}


def trials_of(pair: dict[str, object]) -> list[dict[str, object]]:
    trials = pair["small"]
    assert isinstance(trials, list)
    return trials


def test_the_matrix_run_reports_ids_and_outcomes_and_fails_a_wrong_mark(folder: pathlib.Path) -> None:
    found = run_pytest(folder, "--matrix")
    outcome = {str(line["ids"]): line["outcome"] for line in found}
    assert outcome["['RHO-SER-01']"] == "passed"
    assert outcome["['RHO-SER-07']"] == "failed"
    assert outcome["['RHO-SER-08']"] == "skipped"
    assert len(found) == 8  # the mark of no row is not counted ...
    assert not json.loads((folder / "result.json").read_text())["whole"]  # ... a run of chosen tests is not made a matrix of ...
    text = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "no_row"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "RHO-NONE-99: no row of docs/requirements has this id" in text.stdout  # ... and fails its test


def test_a_row_that_one_parameter_claims_is_judged_by_that_parameter(folder: pathlib.Path) -> None:
    (folder / "test_sample.py").write_text(OF_PARAMETERS)
    outcome = {str(line["ids"]): line["outcome"] for line in run_pytest(folder, "--matrix")}
    assert outcome == {"['RHO-SER-01']": "passed", "['RHO-SER-02']": "failed", "['RHO-SER-03']": "failed"}


def test_the_matrix_is_made_of_the_last_run_of_this_tree(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    results, written = tmp_path / "results.json", ROOT / "build" / "matrix" / f"of-{tmp_path.name}.json"
    monkeypatch.setattr(verdicts, "RESULTS", results)
    monkeypatch.setattr(verdicts, "MATRIX", written)
    monkeypatch.setattr(verdicts, "KEPT", tmp_path / "no-mutants.tsv")
    runs: list[bool] = []

    def run() -> int:  # stands for the run of twenty minutes
        runs.append(True)
        record.save(results, record.tree(), True, [result("now", "failed")])
        return 1

    def made(*options: str) -> tuple[int, list[str], int]:
        monkeypatch.setattr(sys, "argv", ["coverage", *options])
        code = coverage.main()
        return code, json.loads(written.read_text())["RHO-SER-01"]["tests"] if written.exists() else [], len(runs)

    monkeypatch.setattr(coverage, "run_now", run)
    try:
        assert made("--last") == (3, [], 0)
        record.save(results, record.tree(), True, [result("before", "passed")])
        assert made() == (0, ["before"], 0)
        record.save(results, "another tree", True, [result("before", "passed")])
        assert made("--last") == (0, ["before"], 0)
        assert "of another tree than this" in capsys.readouterr().out
        assert made() == (1, ["now"], 1)
        assert made() == (1, ["now"], 1)
        record.save(results, record.tree(), False, [result("half", "passed")])
        assert made() == (1, ["now"], 2)
        assert made("--run") == (1, ["now"], 3)
    finally:
        written.unlink(missing_ok=True)


def result(test: str, outcome: str, *by: str) -> Result:
    return Result(test, ("RHO-SER-01",), by or ("m:f",), outcome)


def pair(test: str, raised: str = "killed", returned: str = "killed", by: str = "m:f") -> Pair:
    return Pair(test, by, ("RHO-SER-01",), raised, returned, "")


@pytest.mark.parametrize(
    ("results", "pairs", "verdict", "mutant"),
    [
        ([], [], "none", "none"),
        ([result("a", "skipped")], [], "none", "none"),
        ([result("a", "passed")], [], "pass", "none"),
        ([result("a", "passed"), result("b", "failed")], [], "fail", "none"),
        ([result("a", "passed")], [pair("a")], "pass", "killed"),
        ([result("a", "passed")], [pair("a", raised="crash")], "pass", "killed"),
        ([result("a", "passed")], [pair("a", raised="crash", returned="crash")], "pass", "alive"),
        ([result("a", "passed")], [pair("a", raised="alive")], "pass", "alive"),
        ([result("a", "passed")], [pair("a", returned="alive")], "pass", "alive"),
        ([result("a", "passed"), result("b", "passed")], [pair("a")], "pass", "none"),
        ([result("a", "passed", "m:f", "m:g")], [pair("a"), pair("a", "hang", by="m:g")], "pass", "alive"),
        ([result("a", "passed")], [pair("b")], "pass", "none"),
    ],
)
def test_a_row_is_killed_only_when_every_test_killed_both_variants_of_every_function(
    results: list[Result], pairs: list[Pair], verdict: str, mutant: str
) -> None:
    entries = matrix(rows(), results, pairs, {"m:f": "cell"})
    assert set(entries) == set(rows())
    assert (entries["RHO-SER-01"]["verdict"], entries["RHO-SER-01"]["mutant"]) == (verdict, mutant)
    assert entries["RHO-SER-02"] == {"verdict": "none", "tests": [], "by": [], "mutant": "none", "reach": ""}


def tried(*verdicts: str, returned: str = "killed") -> str:
    trials = tuple(Trial(f"operator_{number}", verdict) for number, verdict in enumerate(verdicts))
    return Pair("a", "m:f", ("RHO-SER-01",), "crash", returned, "", trials).verdict


def test_of_the_small_changes_of_a_function_an_assertion_must_have_noticed_one() -> None:
    assert tried() == "killed"
    assert tried("alive", "killed", "crash") == "killed"
    assert tried("killed", returned="crash") == "killed"
    assert tried("alive", "crash") == "alive"
    assert tried("crash", "hang") == "crash"
    assert tried("killed", returned="alive") == "alive"


def test_the_matrix_names_what_comes_to_a_row_and_counts_api_only_rows_apart() -> None:
    known = {"m:f": "cell", "m:g": "API only", "m:h": "command"}
    results = [
        Result("a", ("RHO-SER-01",), ("m:f", "m:g"), "passed"),
        Result("b", ("RHO-SER-02",), ("m:g",), "passed"),
        Result("c", ("RHO-SER-03",), ("m:h",), "passed"),
        Result("d", ("RHO-SER-04",), ("m:f",), "skipped"),
    ]
    entries = matrix(rows(), results, [], known)
    assert [entries[f"RHO-SER-0{number}"]["reach"] for number in (1, 2, 3)] == ["cell (1 of 2)", "API only", "command"]
    words = coverage.counted({name: entries[name] for name in (f"RHO-SER-0{number}" for number in (1, 2, 3, 4, 5))})
    assert words == "5 rows: 2 proved (1 cell, 0 program, 1 command), 1 proved API only, 2 open"


def test_a_broken_test_that_never_ends_is_given_up() -> None:
    with pytest.raises(Hang) as caught, time_limit(0.05):
        run_for_ever()
    assert judged([caught.value]) == "hang"


def run_for_ever() -> None:
    while True:
        pass
