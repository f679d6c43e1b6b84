"""docs/guide/conformance.md and conformance-can.md, word for word: every command of their shell blocks is run."""

import contextlib
import io
import pathlib
import re
import shlex

import pytest

import gateway
from gateway.commands.conformance import main

ROOT = pathlib.Path(gateway.__file__).parents[1]
FAULTY = ("drops-its-job", "no-nak", "no-sync", "no-limits", "half-way", "interop-pause")
PAGES = ("conformance.md", "conformance-can.md")


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_the_guide_do_what_it_says(page: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("configs", "gateway"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "guide" / page).read_text()
    lines = [line for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    assert len(lines) >= 3
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
