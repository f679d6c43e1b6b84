"""docs/guide/baps2.md: its ten minutes, word for word."""

import json
import pathlib
import re
import shlex
import subprocess
import sys
import textwrap

import pytest

from hil_tests.purity import ROOT

GUIDE = (ROOT / "docs" / "guide" / "baps2.md").read_text(encoding="utf-8").partition("## In a cell")[0]
SECONDS = 200


def written(folder: pathlib.Path) -> None:
    """The files the guide shows."""
    for block in re.findall(r"^    ```\n(.*?)^    ```$", GUIDE, re.DOTALL | re.MULTILINE):
        for name, text in re.findall(r"^(\S+)\n((?:    .*\n)+)", textwrap.dedent(block), re.MULTILINE):
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(textwrap.dedent(text))


@pytest.mark.timeout(8 * SECONDS)
def test_every_command_of_the_ten_minutes_works(tmp_path: pathlib.Path) -> None:
    written(tmp_path)
    assert {path.name for path in tmp_path.rglob("*.*")} == {"PICK.QLL", "PICK.PKT", "pick.toml"}
    commands = [line for block in re.findall(r"```sh\n(.*?)```", GUIDE, re.DOTALL) for line in block.split("\n") if line.strip()]
    assert len(commands) == 5
    told = {}
    for command in commands:
        words = shlex.split(command)
        assert words[0] == "axisgate"
        more = ["--json"] if words[2] == "run" else []
        done = subprocess.run(
            [sys.executable, "-m", "gateway", *words[1:], *more], cwd=tmp_path, capture_output=True, text=True, timeout=SECONDS, check=False
        )
        assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
        told[words[1] + " " + words[2]] = done.stdout
    found = json.loads(told["program run"])
    assert found["how"] == "ended" and found["sentence"].startswith("PICK ended after ")
    assert found["axes"] == pytest.approx({"X": 100.0, "Y": 40.0, "Z": 90.0, "C": 0.0}, abs=0.1), "by what the drives report"
    assert "target=[100.0, 40.0, 40.0, 0.0]" in told["program trace"]
