"""docs/guide/s5-over-3964r.md is followed word for word, and what it shows is what is printed (`...` stands for anything)."""

import os
import pathlib
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from hil_tests.rig.line_tools.conftest import ROOT

PAGE = ROOT / "docs" / "guide" / "s5-over-3964r.md"
TOOL = ".venv/bin/axisgate"


def steps() -> Iterator[tuple[str, str]]:
    """Commands with what they print."""
    for block in re.findall(r"```console\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        for piece in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, output = piece.partition("\n")
            yield command, output


def pattern(expected: str) -> str:
    """A line of dots alone is any number of lines; dots inside a line are anything in it."""
    parts = []
    for line in expected.splitlines():
        if line == "...":
            parts.append(r"(?:.*\n)*?")
            continue
        parts.append(r"\s*" + r".*".join(re.escape(piece) for piece in line.split("...")) + r"\s*\n")
    return "".join(parts)


def words_of(command: str) -> list[str]:
    words = shlex.split(command)
    assert words[0] == TOOL, command
    return [sys.executable, "-m", "gateway", *words[1:]]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.slow
@pytest.mark.timeout(180)
def test_the_page_works_as_it_is(tmp_path: pathlib.Path) -> None:
    environment = os.environ | {"AXISGATE_RUNTIME": str(tmp_path / "run"), "PYTHONPATH": str(ROOT), "LC_ALL": "C.UTF-8"}
    (first, _), *others = steps()
    assert " run demo --sim" in first
    command = [*words_of(first), "--modbus-port", str(free_port()), "--die-with-parent"]  # so that tests side by side do not meet
    cell = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        limit = time.monotonic() + 30
        while not (tmp_path / "run" / "demo-services.sock").exists() and time.monotonic() < limit:
            time.sleep(0.1)
        time.sleep(1.0)  # its line opens its port a quarter of a second later at the latest
        for command_text, expected in others:
            done = subprocess.run(
                words_of(command_text), cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60, check=False
            )
            printed = done.stderr + done.stdout
            assert re.fullmatch(pattern(expected), printed), f"$ {command_text}\n{printed}\nexpected:\n{expected}"
        assert len(others) >= 10
    finally:
        cell.send_signal(signal.SIGTERM)
        cell.wait(15)


def test_the_pattern_knows_a_wrong_line() -> None:
    assert re.fullmatch(pattern("a ... c\n...\nz\n"), "a b c\n1\n2\nz\n")
    assert not re.fullmatch(pattern("a ... c\n"), "a b d\n")
    assert not re.fullmatch(pattern("a\n"), "a\nmore\n")
