"""docs/guide/conformance.md and conformance-can.md, word for word: every command of their shell blocks is run."""

import contextlib
import io
import json
import pathlib
import re
import shlex

import pytest

import gateway
from gateway.commands.conformance import main
from gateway.conformance.reporting.document import cases_of
from gateway.conformance.reporting.folder import load

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


def test_the_sample_report_is_that_of_its_run(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the command prints, the fields of the failed case, and its trace."""
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    monkeypatch.chdir(tmp_path)
    section = (ROOT / "docs" / "guide" / "conformance.md").read_text().split("## A sample report\n")[1].split("\n## ")[0]
    blocks = re.findall(r"```(sh|text|json)\n(.*?)```", section, re.DOTALL)
    assert [kind for kind, _ in blocks] == ["sh", "text", "json", "text"]
    (_, command), (_, printed), (_, case), (_, trace) = blocks
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main([*shlex.split(command)[2:], "--language", "en"]) == 1
    assert out.getvalue() == printed
    shown = json.loads(case)
    found = next(one for one in cases_of(load(tmp_path / "sample")) if one["id"] == shown["id"])
    assert shown == {key: found[key] for key in shown}
    assert (tmp_path / "sample" / "traces" / f"{shown['id']}.txt").read_text() == trace
