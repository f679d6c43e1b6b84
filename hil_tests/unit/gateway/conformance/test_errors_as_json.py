"""`axisgate conformance ... --json` that stops before the first case: one object on standard output, with the faults."""

import json
import pathlib

import pytest

from gateway.commands.conformance import main

TOUCH = '[port]\nurl = "sim"\n[link]\nnode = 200\nspeeed = 4\n'


def errors(capsys: pytest.CaptureFixture[str]) -> tuple[int, list[str]]:
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert (found["kind"], found["format"], found["cases"]) == ("axisgate conformance", 1, [])
    assert all(fault in err for fault in found["errors"])
    return found["exit"], found["errors"]


def test_faults_of_files_are_in_the_object(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bench.toml").write_text(TOUCH)
    assert main(["run", "canopen-301", "--bench", str(tmp_path / "bench.toml"), "--json"]) == 2
    code, found = errors(capsys)
    assert code == 2 and len(found) == 2
    assert any("link.node" in fault for fault in found) and any("speeed" in fault for fault in found)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("run", "3964", "--port", "sim", "--json"), "suite 3964"),
        (("run", "3964r", "--port", "sim", "--only", "NO", "--json"), "--only NO"),
        (("verify", "nowhere", "--json"), "nowhere"),
        (("compare", "nowhere", "none", "--json"), "nowhere"),
    ],
)
def test_faults_of_the_command_line_are_in_the_object(argv: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(list(argv)) == 2
    code, found = errors(capsys)
    assert code == 2 and words in found[0]


def test_what_the_parser_refuses_is_in_the_object(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "3964r", "--sed", "x", "--json"])
    code, found = errors(capsys)
    assert code == 2 and "--sed" in found[0] and found[0].startswith("axisgate conformance")


def test_an_interrupt_before_the_first_case_is_in_the_object(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gateway.tools.conformance.run.started", interrupted)
    assert main(["run", "3964r", "--port", "sim", "--json"]) == 3
    assert errors(capsys) == (3, ["interrupted before the first case; nothing was tested"])
