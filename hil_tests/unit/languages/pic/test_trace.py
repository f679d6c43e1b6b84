"""axisgate program trace of PIC programs: inputs at their times, bits as they change (rho3 3.5, 6)."""

import json
import pathlib

import pytest

from gateway.commands.program import main

START = "; strobe of the selection after a time\nM2.0 = START_DI\nO10.1 = M3.0 AND NOT FULL\n"
COUNT = "A -PART_DI\nAN M127.0\n= M0.0\nA -PART_DI\n= M127.0\nA M1.0\n= -USER_3_RCI\nA I88.7\n= M5.0\n"
HOLD = "WENN E88.0 DANN SETZEN = 1\nFEED_HOLD_N_RCI = NICHT E88.0 ODER A20.0\n"


def traced(
    folder: pathlib.Path, capsys: pytest.CaptureFixture[str], name: str, source: str, symbols: str, feed: str
) -> list[tuple[float, str, str, int]]:
    (folder / f"{name}.QLS").write_text(source)
    (folder / f"{name}.SYM").write_text(symbols)
    (folder / "feed.toml").write_text(feed)
    assert main(["trace", str(folder), name.lower(), "--feed", str(folder / "feed.toml"), "--json"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    return [(row["t"], row["event"], row.get("name", row["channel"]), row["value"]) for row in rows if not row["channel"].startswith("M1.")]


def test_a_timer_runs_its_clocks_and_an_interlock_takes_the_strobe_back(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    feed = 'until_s = 2\np5_ms = 4\ntimers = [125]\n[[input]]\nname = "START_DI"\nat = 0.4\n[[input]]\nname = "I48.1"\nat = 1.2\n'
    assert traced(tmp_path, capsys, "START", START, "START_DI = I88.3\nFULL = USER_2_RCO\n", feed) == [
        (0.4, "in", "START_DI", 1),
        (0.4, "flag", "M2.0", 1),
        (0.404, "flag", "M4.0", 1),
        (0.904, "out", "STBEXPA_RCI", 1),
        (0.904, "flag", "M3.0", 1),
        (0.904, "flag", "M4.0", 0),
        (1.2, "in", "FULL", 1),
        (1.2, "out", "STBEXPA_RCI", 0),
    ]


def test_a_counter_counts_edges_of_an_instruction_list_down_and_is_reset(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pulses = "".join(f'[[input]]\nname = "PART_DI"\nvalue = {n % 2}\nat = {0.1 * n}\n' for n in range(1, 5))
    feed = f'until_s = 1\ncounters = [2]\n{pulses}[[input]]\nname = "I88.7"\nat = 0.8\n'
    rows = traced(tmp_path, capsys, "COUNT", COUNT, "PART_DI = I88.1\n", feed)
    assert [(at, value) for at, _, name, value in rows if name == "USER_3_RCI"] == [(0.31, 1), (0.81, 0)]


def test_a_feed_that_sets_what_the_program_writes_or_names_nothing_is_one_sentence(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "HOLD.QLS").write_text(HOLD)
    (tmp_path / "HOLD.SYM").write_text("SETZEN = A21.0\n")
    for entry, words in (
        ('[[input]]\nname = "O21.1"', "byte O21 is written by the program"),
        ('[[input]]\nname = "NOTHING"', "NOTHING: no address, no symbol and no signal"),
        ('[[input]]\nname = "I200.1"', "bytes are 0..127"),
        ("timers = [-1]", "timers = -1: a number from 0"),
        ("p3 = 9", "p3 = 9: 8, 16, 24 or 32"),
        ("block_s = 1", "block_s is not a key"),
    ):
        (tmp_path / "feed.toml").write_text(entry)
        assert main(["trace", str(tmp_path), "HOLD.QLS", "--feed", str(tmp_path / "feed.toml")]) == 2
        assert words in capsys.readouterr().err
    (tmp_path / "feed.toml").write_text('until_s = 0.1\n[[input]]\nname = "A20.0"\n')
    assert main(["trace", str(tmp_path), "HOLD.QLS", "--feed", str(tmp_path / "feed.toml")]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[2:] for row in rows if row.endswith(" FEED_HOLD_N_RCI")] == [["out", "O3.3", "=", "1", "FEED_HOLD_N_RCI"]]


def test_a_scan_that_does_not_end_stops_the_pic_with_its_outputs_0(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "LOOP.QLS").write_text("O10.0 = 1\nAGAIN:\nIF I88.0 THEN JUMP AGAIN\n")
    (tmp_path / "feed.toml").write_text('[[input]]\nname = "I88.0"\nat = 0.05\n')
    assert main(["trace", str(tmp_path), "LOOP", "--feed", str(tmp_path / "feed.toml"), "--json"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(row["t"], row["event"], row.get("value", row.get("code"))) for row in rows if not row.get("channel", "").startswith("M")] == [
        (0.0, "out", 1),
        (0.05, "in", 1),
        (0.05, "error", 1275),
        (0.05, "out", 0),
    ]


def test_a_source_with_errors_is_not_run(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "BAD.QLS").write_text("O10.0 = NOBODY\n")
    assert main(["trace", str(tmp_path), "BAD"]) == 1
    assert "BAD.QLS has errors and does not run" in capsys.readouterr().err
