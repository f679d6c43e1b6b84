"""docs/benchmarks.md is one run of one tree, and says nothing of what was not taken."""

import json
import math
import pathlib
from collections.abc import Callable

import pytest

from hil_tests.bench import command
from hil_tests.bench.command import PAGE, known, page, sentence
from hil_tests.bench.figure_row import row


def test_the_page_is_one_run() -> None:
    """An earlier run beside it would be read as if it were of this tree."""
    text = PAGE.read_text(encoding="utf-8")
    assert text.count("\nMeasured ") == 1 and text.count("\n|---|") == 1 and "\n## " not in text
    assert "nan" not in text and "None" not in text


def test_a_reference_that_was_not_taken_is_left_empty() -> None:
    figure = known(row("x.y", 2.0, "ms", 3.0, "by hand"))
    assert json.loads(json.dumps(figure, allow_nan=False))["reference_value"] is None
    assert page([figure]).splitlines()[-1] == "| x.y | 2.0 | ms | by hand |  |  | 3.0 | yes |"
    assert sentence(figure) == "met   x.y: 2.0 ms  (goal 3.0; by hand)"
    assert sentence(known(row("x.y", math.inf, "ms", 3.0))) == "MISS  x.y: inf ms  (goal 3.0)"
    assert sentence(known(row("x.y", 2.0, "ms", 3.0, "by hand", 4.0))) == "met   x.y: 2.0 ms  (goal 3.0; by hand: 4.0)"


def test_a_bench_that_breaks_off_costs_the_others_nothing(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(arguments: object) -> list[command.Figure]:
        raise TimeoutError("the cell did not come up")

    figure: command.Figure = {"figure": "b.x", "value": 1.0, "unit": "s", "goal": 2.0, "met": True}
    monkeypatch.setattr(command, "BENCHES", {"a": broken, "b": lambda arguments: [figure]})
    monkeypatch.setattr(command, "PAGE", tmp_path / "benchmarks.md")
    monkeypatch.setattr(command, "REFERENCES", ())
    assert command.main(["all"]) == 3
    assert not (tmp_path / "benchmarks.md").exists()
    said = capsys.readouterr()
    assert "b.x" in said.out
    assert "the cell did not come up" in said.err and "not measured: a " in said.err


def test_a_bench_that_fails_among_others_is_repeated_at_the_end_in_its_place_on_the_page(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = list[str]()

    def bench(name: str, failures: int) -> Callable[[object], list[command.Figure]]:
        def run(arguments: object) -> list[command.Figure]:
            runs.append(name)
            if runs.count(name) <= failures:
                raise TimeoutError("did not end")
            return [{"figure": f"{name}.x", "value": 1.0, "unit": "s", "goal": 2.0, "met": True}]

        return run

    monkeypatch.setattr(command, "BENCHES", {"a": bench("a", 1), "b": bench("b", 0)})
    monkeypatch.setattr(command, "PAGE", tmp_path / "benchmarks.md")
    monkeypatch.setattr(command, "REFERENCES", ())
    assert command.main(["all"]) == 0 and runs == ["a", "b", "a"]
    rows = (tmp_path / "benchmarks.md").read_text().splitlines()[-2:]
    assert [row.split(" | ")[0] for row in rows] == ["| a.x", "| b.x"]
    assert "a failed (the cause is above) and is repeated" in capsys.readouterr().err
    runs.clear()
    assert command.main(["a"]) == 3 and runs == ["a"], "one bench alone is not repeated"
