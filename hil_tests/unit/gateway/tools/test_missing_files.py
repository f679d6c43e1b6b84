"""A file that is not there or is none of its kind: the same words from every tool, and the exit code of its family."""

import pathlib
from collections.abc import Callable

import pytest

from gateway.commands import line, scope
from gateway.tools.bus import infer, load, monitor

GONE = "gone.log"
CASES: list[tuple[Callable[[list[str]], int], list[str], int]] = [
    (line.main, ["export", GONE, "-o", "x.pcapng"], 3),
    (line.main, ["learn", GONE], 3),
    (line.main, ["monitor", "--record", GONE], 3),
    (scope.main, ["export", GONE, "-o", "x.csv"], 2),
    (infer.main, [GONE], 2),
    (load.main, ["--log", GONE], 2),
    (monitor.main, ["--from", GONE], 2),
]


@pytest.mark.parametrize(("main", "words", "code"), CASES, ids=[" ".join(words[:2]) for _, words, _ in CASES])
def test_a_missing_file_is_named_without_an_error_number(
    main: Callable[[list[str]], int],
    words: list[str],
    code: int,
    tmp_path: pathlib.Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == code
    said = capsys.readouterr().err
    assert f"{GONE}: No such file or directory" in said and "Errno" not in said


def test_a_file_that_is_no_trace_is_shown_with_its_beginning_only(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "x.rec"
    file.write_bytes(b"\xd0\x7f" * 5000 + b"\n")
    assert line.main(["export", str(file), "-o", str(tmp_path / "x.pcapng")]) == 2
    assert line.main(["learn", str(file)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert all("neither a line record" in each and len(each) < 500 for each in said) and len(said) == 2
