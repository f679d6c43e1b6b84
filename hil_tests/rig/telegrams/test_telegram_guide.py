"""docs/guide/telegrams.md: every example runs as it stands there."""

import pathlib
import re
import shlex
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator

import pytest

from drivers.ports.base import runtime_dir
from gateway.files.find import find_config
from hil_tests.rig.telegrams.conftest import Running

GUIDE = (pathlib.Path(__file__).parents[3] / "docs" / "guide" / "telegrams.md").read_text(encoding="utf-8")
BROKEN = """format = 1
[cell]
name = "Broken on purpose"
[[line]]
name = "V24_1"
port = "sim"
layer = "telegrams"

# four faults, one after the other

[[telegram]]
line = "V24_1"
name = "A"
match = [{ byte = 2, hex = "FF" }]
length = 9
fields = [{ byte = 4, type = "INTEGRE", to = "a.one" }]

[[telegram]]
line = "V24_1"
name = "B"
match = [{ byte = 2, text = "OR" }]
fields = [{ byte = 0, type = "WORD", to = "b.one" },
          { byte = 1, type = "BYTE", to = "b.two" }]
length = 6
[[telegram]]
line = "V24_1"
name = "C"
match = [{ byte = 2, text = "O" }]
[[telegram]]
line = "V24_1"
name = "D"
match = [{ byte = 2, text = "X" }]
length = 6
fields = [{ byte = 3, type = "REAL", to = "d.one" }]
[[telegram]]
line = "V24_1"
name = "E"
when = "rising a.one"
build = [{ type = "INTEGER", from = "a.one" }]
"""


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", GUIDE, re.DOTALL)


def examples(block: str) -> Iterator[tuple[list[str], str]]:
    """(words of the command, what it prints)."""
    for part in block.split("$ ")[1:]:
        command, _, printed = part.partition("\n")
        yield shlex.split(command), printed


def axisgate(*words: str, folder: pathlib.Path | None = None) -> str:
    done = subprocess.run([sys.executable, "-m", "gateway", *words], capture_output=True, text=True, timeout=60, check=False, cwd=folder)
    return done.stdout + done.stderr


def test_the_tables_of_the_guide_are_those_of_the_shipped_cell() -> None:
    (tables,) = blocks("toml")
    shipped = find_config("host-telegrams", "cells").read_text(encoding="utf-8")

    def bare(text: str) -> list[str]:
        return [line.split("#")[0].strip() for line in text.splitlines() if line.split("#")[0].strip()]

    assert bare(tables) == bare(shipped[shipped.index("[[line]]") :])


def test_the_host_of_the_guide_and_the_values_behind_it(running: Running, tmp_path: pathlib.Path) -> None:
    running("host-telegrams")
    program = tmp_path / "host.py"
    program.write_text(textwrap.dedent(blocks("python")[0]), encoding="utf-8")
    port = runtime_dir() / "host-telegrams-V24_1-a"
    host = subprocess.Popen([sys.executable, str(program), str(port)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert host.stdout is not None
    printed = host.stdout.readline()
    commands = list(examples(blocks("console")[0]))
    assert len(commands) == 7
    for (name, *words), wanted in commands:
        assert name == "axisgate"
        told, end = axisgate(*words), time.monotonic() + 10.0
        while told != wanted and "--set" not in words and time.monotonic() < end:
            told = axisgate(*words)
        assert told == wanted
    assert printed + host.communicate(timeout=20)[0] == blocks("text")[0]


@pytest.mark.parametrize("block", blocks("console")[1:])
def test_what_check_says(block: str, tmp_path: pathlib.Path) -> None:
    (tmp_path / "broken.toml").write_text(BROKEN, encoding="utf-8")
    ((_, *words), wanted) = next(examples(block))
    assert axisgate(*words, folder=tmp_path) == wanted
