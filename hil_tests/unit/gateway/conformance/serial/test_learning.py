"""A draft out of a recorded line: types, ranges, periods, life words; what cannot be known stays open."""

import random
import struct
import tomllib

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.lines.learning import draft, guesses, learn
from gateway.tools.line.learn import NoTrace, characters, decoded, line_format
from protocols.base.machine import ms
from protocols.base.step5 import Step5Type, encode
from protocols.p3964r.characters import wire_block


def samples(*words: int) -> list[bytes]:
    return [(word & 0xFFFF).to_bytes(2, "big") for word in words]


def test_what_a_word_looks_like() -> None:
    assert guesses(samples(*range(100, 130)), 31)[0].life
    assert guesses(samples(0, 1, 1, 0x101, 0x100, 0), 0)[0].kind == "bit"
    number = guesses(samples(-350, 1200, 0, 8000, 77), 2)[0]
    assert (number.kind, number.life) == ("KF", False)
    assert "-350..8000" in number.evidence
    constant = guesses(samples(5, 5, 5), 7)[0]
    assert constant.kind == ""
    assert constant.evidence == "constant 0005h"


def test_floats_are_distinguished_from_two_words_and_kg_from_real() -> None:
    chance = random.Random(1)
    values = [chance.uniform(100, 2000) for _ in range(30)]
    real = guesses([struct.pack(">f", value) for value in values], 0)
    assert [(guess.kind, guess.words) for guess in real] == [("REAL", 2)]
    kg = guesses([encode(Step5Type.KG, value) for value in values], 0)
    assert [(guess.kind, guess.words) for guess in kg] == [("KG", 2)]
    two = guesses([a + b for a, b in zip(samples(*range(20)), samples(*range(0, 400, 20)), strict=True)], 0)
    assert [guess.words for guess in two] == [1, 1]


def record(rounds: int = 12) -> str:
    """SEND of 3 words each 100 ms, FETCH of 2; side A is the PLC."""
    lines, now = ["# 0 ready name=x baud=9600 bits=11 scheduling=normal\n"], 1_000_000

    def put(side: str, data: bytes) -> None:
        nonlocal now
        for byte in data:
            now += 1_145_834
            lines.append(f"{now} {side} {byte:02x}\n")

    def block(side: str, other: str, data: bytes) -> None:
        for who, what in ((side, b"\x02"), (other, b"\x10"), (side, wire_block(data)), (other, b"\x10")):
            put(who, what)

    for number in range(rounds):
        start = now
        words = b"".join(samples((number % 2) << 8, 100 * number, number))
        block("A", "B", bytes.fromhex("000041440A000003FFFF") + words)
        block("B", "A", bytes(4))
        block("A", "B", bytes.fromhex("000045440B000002FFFF"))
        block("B", "A", bytes(4) + b"".join(samples(7 * number, number)))
        now = start + ms(200)
    return "".join(lines)


def test_the_draft_names_lines_blocks_periods_and_evidence() -> None:
    text = record()
    seen = learn(decoded(text))
    assert (seen.blocks, seen.bad_checks, seen.active) == (48, 0, "A")
    assert [(job.job, job.db, job.words, job.period) for job in seen.jobs] == [("SEND", 10, 3, ms(200)), ("FETCH", 11, 2, ms(200))]
    cell = draft(seen, "x.rec", *line_format(text))
    parsed = tomllib.loads(cell)
    assert parsed["line"][0]["format"] == "9600 8E1"
    assert parsed["line"][0]["role"] == "passive"
    assert parsed["line"][0]["supervision"] == {"max_silence_ms": 1000, "life_word": "DB10.DW2"}
    assert [(db["number"], db["words"], db["writer"]) for db in parsed["db"]] == [(10, 3, "plc"), (11, 2, "axisgate")]
    assert parsed["db"][0]["entries"] == [{"at": "DW 2", "type": "KF", "to": "line.plc.life"}]
    assert parsed["db"][1]["entries"] == [{"at": "DW 1", "type": "KF", "from": "cell.life"}]
    assert "# SEND DW 0, 3 words: 12 times, every 200 ms" in cell
    assert '# { at = "DW 1", type = "KF", to = "...", unit = "..." },  # 0..1100' in cell
    assert '# { at = "D 0.n", type = "bit", to = "..."' in cell


def test_a_refused_job_says_nothing_of_the_size_of_a_block() -> None:
    lines, now = list[str](), 0
    for command, number in (("000045440A000002FFFF", 0), ("000045440AFF0002FFFF", 0x14)):
        reaction = bytes((0, 0, 0, number)) + (bytes(4) if number == 0 else b"")
        for who, what in (
            *(("A", b"\x02"), ("B", b"\x10"), ("A", wire_block(bytes.fromhex(command))), ("B", b"\x10")),
            *(("B", b"\x02"), ("A", b"\x10"), ("B", wire_block(reaction)), ("A", b"\x10")),
        ):
            now += ms(5)
            lines.append(f"{now} {who} {what.hex()}\n")
    text = draft(learn(decoded("".join(lines))), "x", 9600, "8E1")
    assert tomllib.loads(text)["db"][0]["words"] == 2
    assert "# FETCH DW 255, 2 words: 1 times, once, 1 refused" in text


def test_a_side_that_includes_stx_and_raw_blocks_are_named() -> None:
    lines = ["1000000 A 02\n", "2000000 B 10\n", f"3000000 A {(b'AB' + bytes((0x10, 0x03, 0x12))).hex()}\n", "4000000 B 15\n"]
    lines += ["5000000 A 02\n", "6000000 B 10\n", f"7000000 A {wire_block(b'HELLO').hex()}\n", "8000000 B 10\n"]
    cell = draft(learn(decoded("".join(lines))), "x", 9600, "8E1")
    assert "1 block checks are off by 02h" in cell
    assert "1 blocks are not RK512, the first: 48 45 4c 4c 4f" in cell
    assert 'layer    = "telegrams"' in cell


def test_lost_and_spoiled_characters_of_a_record() -> None:
    text = "1 A 02\n2 A 41 lost\n3 A 42 parity\n4 A 43 flip=44\n"
    assert [what if isinstance(what, int) else what.name for _, _, what in characters(text)] == [0x02, "PARITY", 0x44]


def test_a_journal_is_read_as_well() -> None:
    text = (
        "dialogue x\nstation side=B\n   0.0 hears 02\n   1.0 says 10\n   2.0 hears " + wire_block(b"HELLO").hex(" ") + "\n   9.0 says 10\n"
    )
    assert [one.kind for one in decoded(text)] == ["STX", "DLE", "BLOCK", "DLE"]


def test_what_is_no_trace_is_said() -> None:
    for text in ("hello world\n", "1 Q 02\n"):
        with pytest.raises(NoTrace, match="neither a line record nor a journal"):
            decoded(text)


def test_a_draft_of_raw_blocks_is_a_cell_as_well() -> None:
    lines = ["1000000 A 02\n", "2000000 B 10\n", f"3000000 A {wire_block(b'HELLO').hex()}\n", "4000000 B 10\n"]
    cell = load_cell("draft.toml", draft(learn(decoded("".join(lines))), "x", 9600, "8E1"))
    assert cell.line[0].layer == "telegrams"
    assert load_cell("draft.toml", draft(learn(decoded(record())), "x", 9600, "8E1")).line[0].layer == "rk512"
