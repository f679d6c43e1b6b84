"""Coverage matrix and mutants over a small folder of sample tests, by real pytest runs."""

import json
import pathlib
import subprocess
import sys

import pytest

from hil_tests.matrix import coverage, record, verdicts
from hil_tests.matrix.catalogue import ROOT, rows
from hil_tests.matrix.mutant_plugin import Hang, judged, time_limit
from hil_tests.matrix.record import Result
from hil_tests.matrix.verdicts import Pair, matrix

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
    pairs = run_pytest(folder, "-p", "hil_tests.matrix.mutant_plugin", "-p", "no:timeout", "--mutants")
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


def test_the_matrix_run_tells_ids_and_outcomes_and_fails_a_wrong_mark(folder: pathlib.Path) -> None:
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


def test_the_matrix_is_made_of_the_last_run_of_this_tree(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    results, written = tmp_path / "results.json", ROOT / "build" / "matrix" / f"of-{tmp_path.name}.json"
    monkeypatch.setattr(verdicts, "RESULTS", results)
    monkeypatch.setattr(verdicts, "MATRIX", written)
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
        ([result("a", "passed")], [pair("a", raised="crash")], "pass", "alive"),
        ([result("a", "passed")], [pair("a", returned="alive")], "pass", "alive"),
        ([result("a", "passed"), result("b", "passed")], [pair("a")], "pass", "none"),
        ([result("a", "passed", "m:f", "m:g")], [pair("a"), pair("a", "hang", by="m:g")], "pass", "alive"),
        ([result("a", "passed")], [pair("b")], "pass", "none"),
    ],
)
def test_a_row_is_killed_only_when_every_test_killed_both_variants_of_every_function(
    results: list[Result], pairs: list[Pair], verdict: str, mutant: str
) -> None:
    entries = matrix(rows(), results, pairs)
    assert set(entries) == set(rows())
    assert (entries["RHO-SER-01"]["verdict"], entries["RHO-SER-01"]["mutant"]) == (verdict, mutant)
    assert entries["RHO-SER-02"] == {"verdict": "none", "tests": [], "by": [], "mutant": "none"}


def test_a_broken_test_that_never_ends_is_given_up() -> None:
    with pytest.raises(Hang) as caught, time_limit(0.05):
        run_for_ever()
    assert judged([caught.value]) == "hang"


def run_for_ever() -> None:
    while True:
        pass
