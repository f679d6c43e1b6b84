"""A bar on a terminal, nothing in a pipe."""

import io
import sys

import pytest

from gateway.tools.progress import Progress, steps


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def clocked(total: float, monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> tuple[Progress, list[float]]:
    now = [0.0]
    monkeypatch.setattr(sys, "stderr", stream)
    return Progress("replay", total, lambda: now[0]), now


def test_a_terminal_sees_how_much_is_done_and_how_long_it_still_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    bar, now = clocked(200.0, monkeypatch, stream)
    bar(0)
    now[0] = 30.0
    bar(50)
    shown = stream.getvalue().rpartition("\r")[2]
    assert shown == "\x1b[Kreplay [########......................]  25 %  1:30 left"
    bar.close()
    assert stream.getvalue().endswith("\r\x1b[K"), "the line is free again"


def test_it_is_drawn_ten_times_a_second_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    bar, now = clocked(100.0, monkeypatch, stream)
    for n in range(100):
        now[0] = n / 100
        bar(n)
    assert stream.getvalue().count("\r") == 10


def test_a_pipe_sees_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    assert list(steps("bench", [1, 2, 3])) == [1, 2, 3]
    assert stream.getvalue() == ""


def test_every_step_is_shown_when_it_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    assert list(steps("bench", (n for n in "ab"))) == ["a", "b"]
    assert stream.getvalue().startswith("\r\x1b[Kbench: 0") and stream.getvalue().endswith("\r\x1b[K")
