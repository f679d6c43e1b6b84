"""docs/guide/conformance.md, word for word: every command of its shell blocks is run, with the exit codes it names."""

import contextlib
import io
import pathlib
import re
import shlex

import pytest

import gateway
from gateway.commands.conformance import main

ROOT = pathlib.Path(gateway.__file__).parents[1]
FAULTY = ("drops-its-job", "no-nak")


def test_the_commands_of_the_guide_do_what_it_says(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("configs", "gateway"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "guide" / "conformance.md").read_text()
    lines = [line for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    assert len(lines) >= 8
    for line in lines:
        command, _, target = line.partition(" > ")
        words = shlex.split(command)
        assert words[:2] == ["axisgate", "conformance"]
        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
            code = main(words[2:])
        assert code == (1 if any(name in command for name in FAULTY) else 0), line
        if target:
            (tmp_path / target).write_text(out.getvalue())
    assert "page 1 of" in (tmp_path / "out" / "report.html").read_text()
