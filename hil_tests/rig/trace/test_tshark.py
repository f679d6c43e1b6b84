"""tshark, which we did not write, opens an export and our dissector names the turns.  Telegrams by hand (serial-protocols 1.2, 2)."""

import json
import pathlib
import subprocess
from typing import Any

import pytest

from gateway.commands.line_export import main as export
from gateway.files.find import find_config

LUA = find_config("axisgate_3964r.lua", "wireshark")
FETCH = "00 00 45 44 05 0A 00 07 FF FF 10 03 1A"  # vector 8: DB 5 from DW 10, 7 words
ANSWER = "00 00 00 00 00 01 00 02 00 03 00 04 00 05 00 06 00 07 10 03 13"  # no error, 14 bytes
SEND = "00 00 41 44 10 10 10 10 00 02 06 24 DE AD BE EF 10 03 14"  # DB 16 DW 16, 2 words, flag 6.4 with CPU 2
ERROR = "00 00 00 14 10 03 07"
FOLLOW = "FF 00 41 44 DE AD BE EF 10 03 CB"  # vector 11


def record(*said: str) -> str:
    """ "A 02", "B 10 lost" 5 ms after one another, as the line process writes it."""
    lines = []
    for n, words in enumerate(said, 1):
        side, data, *mark = words.split("|") if "|" in words else (words[0], words[1:])
        lines.append(" ".join([str(n * 5_000_000), side.strip(), data.replace(" ", ""), *mark]))
    return "\n".join(lines) + "\n"


def turn(block: str, side: str, answer: str = "10") -> list[str]:
    """A whole exchange."""
    other = "B" if side == "A" else "A"
    return [f"{side} 02", f"{other} 10", f"{side} {block}", f"{other} {answer}"]


def decoded(text: str, folder: pathlib.Path, *options: str) -> list[dict[str, Any]]:
    """The packets as tshark shows them: {field: value} with all layers in one."""
    trace, capture = folder / "line-plc1.rec", folder / "plc1.pcapng"
    trace.write_text(text, encoding="ascii")
    assert export([str(trace), "-o", str(capture), "--start", "2026-11-20T08:00:00+00:00", *options]) == 0
    command = ["tshark", "-X", f"lua_script:{LUA}", "-2", "-r", str(capture), "-T", "json", "--no-duplicate-keys"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and "Lua: Error" not in done.stderr + done.stdout, done.stderr
    packets = []
    for packet in json.loads(done.stdout):
        layers = packet["_source"]["layers"]
        packets.append({**layers["frame"], **layers.get("p3964r", {}), **layers.get("rk512", {}), "columns": layers.keys()})
    return packets


def lines(text: str, folder: pathlib.Path) -> list[str]:
    """One line a packet, as `tshark -r` prints it: direction, protocol, info."""
    capture = folder / "plc1.pcapng"
    decoded(text, folder)
    command = ["tshark", "-X", f"lua_script:{LUA}", "-r", str(capture), "-T", "fields", "-E", "separator=|"]
    command += ["-e", "_ws.col.Source", "-e", "_ws.col.Protocol", "-e", "_ws.col.Info"]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()


@pytest.mark.tshark
def test_turns_are_named(tmp_path: pathlib.Path) -> None:
    said = record(*turn("41 10 03 53", "A", "15"), "A 02", "B 15", *turn("41 10 10 42 10 03 10", "B"), "B 15", "A 07 08", "B 10")
    assert lines(said, tmp_path) == [
        "A|3964R|STX: wish to send",
        "B|3964R|DLE: ready",
        "A|3964R|block, 1 bytes, BCC 53 wrong (52 expected)",
        "B|3964R|NAK: block bad",
        "A|3964R|STX: wish to send",
        "B|3964R|NAK: not ready",
        "B|3964R|STX: wish to send",
        "A|3964R|DLE: ready",
        "B|3964R|block, 3 bytes, BCC 10 ok",
        "A|3964R|DLE: block good",
        "B|3964R|NAK: gave up, or idle",
        "A|3964R|2 stray characters",
        "B|3964R|DLE: DLE out of turn",
    ]


@pytest.mark.tshark
def test_rk512_telegrams_and_their_reactions(tmp_path: pathlib.Path) -> None:
    said = record(
        *turn(FETCH, "A"), *turn(ANSWER, "B"), *turn(SEND, "A"), *turn(ERROR, "B"), *turn(FOLLOW, "A"), *turn("00 00 00 99 10 03 8A", "B")
    )
    blocks = [packet for packet in decoded(said, tmp_path) if packet.get("p3964r.kind") == "4"]
    fetch, answer, send, error, follow, unknown = blocks
    assert all(packet["p3964r.bcc.ok"] in ("1", True, "True") for packet in blocks)
    assert (fetch["rk512.command"], fetch["rk512.area"], fetch["rk512.db"], fetch["rk512.word"], fetch["rk512.amount"]) == (
        "0x45", "0x44", "5", "10", "7",
    )  # fmt: skip
    assert fetch["rk512.coordination_flag"] == "none" and fetch["rk512.unit"] == "words" and "rk512.data" not in fetch
    assert answer["rk512.error"] == "0x00" and answer["rk512.request"] == "3"
    assert answer["rk512.data"] == "00:01:00:02:00:03:00:04:00:05:00:06:00:07"
    assert (send["rk512.command"], send["rk512.db"], send["rk512.word"], send["rk512.data"]) == ("0x41", "16", "16", "de:ad:be:ef")
    assert send["rk512.coordination_flag"] == "6.4, CPU 2"
    assert (error["rk512.error"], error["rk512.error.text"]) == ("0x14", "block missing or too short")
    assert error["rk512.telegram"] == "reaction to SEND, error 14h: block missing or too short"
    assert follow["rk512.telegram"] == "follow-on SEND D, 4 bytes of data" and follow["rk512.data"] == "de:ad:be:ef"
    assert unknown["rk512.error.text"] == "unknown number"


@pytest.mark.tshark
def test_a_raw_telegram_is_no_rk512_and_the_stamps_are_nanoseconds(tmp_path: pathlib.Path) -> None:
    packets = decoded(record(*turn("00 00 4F 52 01 10 03 0F", "A"), *turn("00 00 00 00 10 03 13", "B")), tmp_path)
    assert not any("rk512" in packet["columns"] for packet in packets)
    assert packets[2]["p3964r.data"] == "00:00:4f:52:01"
    assert [packet["frame.time_relative"] for packet in packets[:3]] == ["0.000000000", "0.005000000", "0.010000000"]
    assert packets[0]["frame.time_epoch"] == "1795161600.000000000"
    assert packets[0]["frame.interface_id_tree"]["frame.interface_name"] == "line-plc1"


@pytest.mark.tshark
def test_damage_is_marked_and_a_check_off_by_02_is_explained(tmp_path: pathlib.Path) -> None:
    said = record("A|02|lost", "A 02", "B 10", "A 41", "A|42|parity", "A 10 03 12", "B 15", *turn("41 10 03 50", "A", "15"))
    told = lines(said, tmp_path)
    assert told[0] == "A|3964R|STX: wish to send [did not arrive]"
    assert told[3] == "A|3964R|block, 2 bytes, BCC 12 wrong (10 expected) [parity]"
    command = [
        "tshark",
        "-X",
        f"lua_script:{LUA}",
        "-r",
        str(tmp_path / "plc1.pcapng"),
        "-Y",
        "p3964r.bcc.with_stx",
        "-T",
        "fields",
        "-e",
        "frame.number",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["4", "8"]


@pytest.mark.tshark
def test_3964_blocks_have_no_check(tmp_path: pathlib.Path) -> None:
    packets = decoded(record(*turn("41 10 03", "A")), tmp_path, "--no-check")
    assert packets[2]["p3964r.data"] == "41" and "p3964r.bcc" not in packets[2] and packets[3]["p3964r.meaning"] == "block good"
