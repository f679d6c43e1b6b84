"""Journal, decoded lines and buses, evidence and refusals in German: every sentence that the code writes there has one."""

import ast
import pathlib
from collections.abc import Iterator

import pytest

import gateway
from gateway.files.find import read_evidence
from gateway.files.texts import read_texts
from gateway.pure.buses.decoder import canopen_text
from gateway.pure.lines.decoder import ERRORS, LineDecoder
from gateway.pure.lines.fault_texts import FAILED, REFUSED, STAGES
from gateway.pure.modbus import texts as modbus_words
from gateway.pure.reports.spoken import Spoken
from gateway.web.cell_view import _parts, plain
from gateway.web.german import german, says
from protocols.base.machine import Frame

GATEWAY = pathlib.Path(gateway.__file__).parent
VALUE = "7"
ONLY_VALUES = "7"  # of a sentence that is put together elsewhere nothing is left but this
JOURNALS = ("journal", "_journal", "_report", "_say", "print")
OF_A_RUN = ("services", "processes", "cycle", "northbound", "links/modbus", "runtime")
SAME = {"override"}  # the German word is the same


def written() -> Iterator[tuple[str, str]]:
    """(place, sentence) of everything a process of a run writes into the journal or prints for it; what is filled in becomes 7."""
    for folder in OF_A_RUN:
        for path in sorted((GATEWAY / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Call):
                    yield from ((f"{path.relative_to(GATEWAY)}:{node.lineno}", words) for words in sentences(node))


def sentences(call: ast.Call) -> Iterator[str]:
    called = call.func
    name = called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""
    owner = called.value if isinstance(called, ast.Attribute) else None
    of = owner.attr if isinstance(owner, ast.Attribute) else owner.id if isinstance(owner, ast.Name) else ""
    if not (name in JOURNALS or (name in ("write", "_write") and of in ("journal", "_journal", "self"))):
        return
    for argument in call.args[-2:]:
        if isinstance(argument, ast.JoinedStr) or (isinstance(argument, ast.Constant) and isinstance(argument.value, str)):
            words = shown(argument)
            if " " in words.strip() and words.replace(VALUE, "").strip(" :;,()%-") not in ("", "by"):
                yield words


def shown(text: ast.expr) -> str:
    if isinstance(text, ast.Constant):
        return str(text.value)
    assert isinstance(text, ast.JoinedStr)
    return "".join(str(part.value) if isinstance(part, ast.Constant) else VALUE for part in text.values)


def test_everything_written_into_the_journal_has_german_words() -> None:
    found = dict.fromkeys(words for _, words in written())
    assert len(found) > 30
    missing = {f"{place}: {words}" for place, words in written() if german(words) == words}
    assert not missing, "give them a line in configs/texts/journal.toml: " + "\n".join(sorted(missing))


REASONS = (
    "links/canopen/master.py",
    "../drivers/drives/io_boot.py",
    "../drivers/drives/cia402_manual.py",
    "../drivers/drives/referencing.py",
)


def reasons() -> Iterator[str]:
    """What drives and couplers on CANopen and referencing say of themselves: sentences of four words and more."""
    for name in REASONS:
        tree = ast.parse((GATEWAY / name).read_text())
        parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
        comments = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if id(node) in parts | comments or not isinstance(node, ast.JoinedStr | ast.Constant):
                continue
            words = shown(node)
            if (
                len(words.split()) > 3
                and not words.startswith(" ")
                and not set(words.split()) <= {VALUE, f"({VALUE})", f"{VALUE}:"}
                and "(node 7)" not in words
            ):
                yield words


def test_reasons_of_drives_and_couplers_have_german_words() -> None:
    found = sorted(set(reasons()))
    assert len(found) > 20
    assert [words for words in found if german(words) == words] == []
    said = german("drive is not started up: A1: the drive did not reach switched on; it is tried again")
    assert said.startswith("Antrieb ist nicht hochgelaufen: A1: der Antrieb hat ")


@pytest.mark.parametrize(
    "english, expected",
    [
        ("services started, pid 4711", "services gestartet, PID 4711"),
        ("line-plc1 ended with signal SIGKILL; restart in 2 s", "line-plc1 durch Signal SIGKILL beendet; Neustart in 2 s"),
        (
            "command source 2 plc2: silent for 500 ms; stop_on_path",
            "Befehlsquelle 2 plc2: seit 500 ms stumm; Halt auf der Bahn",
        ),
        ("command source 2: ptp_absolute done", "Befehlsquelle 2: PTP-Fahrt: ausgeführt"),
        ("DB11 DW 2 to FF83h forced by anna", "DB11 DW 2 auf FF83h gesteuert von anna"),
        ("all forces ended by anna", "alles Steuern beendet von anna"),
        ("RC input 40 forced to 1 by anna", "RC-Eingang 40 auf 1 gesteuert von anna"),
        (
            "Modbus client far: no connection to tcp://127.0.0.1:9: Connection refused; it is tried again until it exists",
            "Modbus-Client far: keine Verbindung zu tcp://127.0.0.1:9: Verbindung abgewiesen; neuer Versuch, bis sie hergestellt ist",
        ),
        (
            "cycle: broker:a-drives: nothing is sent while it is active; another master is active on this bus: SYNC (080h)",
            "cycle: broker:a-drives: solange er sendet, wird nichts gesendet; ein anderer Master sendet auf diesem Bus: SYNC (080h)",
        ),
        ("command source 2: enable refused: drives are off: A6", "Befehlsquelle 2: Antriebe ein: abgelehnt: Antriebe sind aus: A6"),
        (
            "the PLC process has failed: its outputs are 0 until it is back",
            "der SPS-Prozess ist ausgefallen: Seine Ausgänge sind 0, bis er wieder läuft",
        ),
        ("PLC: door open (MAIN step 4)", "SPS: door open (MAIN Schritt 4)"),
        ("PLC: PLC error 7000", "SPS: SPS-Fehler 7000"),
        ("PLC: System error 1052", "SPS: Systemfehler 1052"),
        ("PLC: Text 5 is not in PLCMSG_CNF", "SPS: Text 5 steht nicht in PLCMSG_CNF"),
        ("PLC programs: a.plc: line 3", "SPS-Programme: a.plc: Zeile 3"),
        ("PLC RUN", "SPS RUN"),
        ("a tool's request failed: IndexError: index out of range", "Anfrage eines Werkzeugs gescheitert: IndexError: index out of range"),
        ("what nobody has German for", "what nobody has German for"),
    ],
)
def test_a_sentence_of_the_journal(english: str, expected: str) -> None:
    assert german(english) == expected
    assert says(english) == [english, expected]


def test_names_keep_the_letters_they_have() -> None:
    """What a sentence names comes back as it was, whatever stands in it."""
    for name in ("Ofen 1", "a; b", "{0}", "x: y", "(.*)", "\\1"):
        assert name in german(f"RC input 40 forced to 1 by {name}")


def test_what_a_line_says_is_decoded_in_german() -> None:
    decoder = LineDecoder(both=True)
    block = bytes.fromhex("0000 4144 0A00 0001 FFFF 1234")
    check = 0
    for each in (*block, 0x10, 0x03):
        check ^= each
    heard = [("A", b"\x02"), ("B", b"\x10"), ("A", block + b"\x10\x03" + bytes((check,))), ("B", b"\x10"), ("A", b"\x55"), ("B", b"\x15")]
    told = [german(one.text) for side, data in heard for what in data for one in decoder.take(1000, side, what)]
    assert told[0] == "STX: Sendewunsch" and told[1] == "DLE: bereit"
    assert any("1 Wörter" in each for each in told) and any("Zeichen außerhalb eines Blocks 55h" in each for each in told)


def test_every_word_of_the_line_decoder_and_of_line_faults_has_german() -> None:
    for number, words in ERRORS.items():
        assert german(f"reaction {number:02X}h {words}") != f"reaction {number:02X}h {words}"
    for words in (*REFUSED.values(), *FAILED.values()):
        assert german(words) != words
    for stage in STAGES.values():
        for why in FAILED.values():
            said = german(f"plc1: a block is sent again: {why} {stage}")
            assert stage not in said and why not in said and said.startswith("plc1: ein eigener Block wird wiederholt: ")


def test_every_modbus_exchange_has_german() -> None:
    asked = [*modbus_words.READS, *modbus_words.NAMES]
    for function in asked:
        words = modbus_words.exchange_text(bytes((function,)) + bytes.fromhex("0001 0002 0003 0004 04 0001 0002"), b"")
        assert german(words.asked) != words.asked, words.asked
        assert german(words.answered) == "keine Antwort"
    for code in (*modbus_words.FAULTS, 99):
        words = modbus_words.exchange_text(b"\x03\0\1\0\1", bytes((0x83, code)))
        assert german(words.answered).startswith("Ausnahme ") and words.answered.split(" ", 2)[2] not in german(words.answered)


@pytest.mark.parametrize(
    "identifier, data, expected",
    [
        (0x000, "0103", "NMT Knoten 3 starten"),
        (0x000, "8100", "NMT alle Knoten rücksetzen"),
        (0x603, "4018100100000000", "SDO-Anfrage an Knoten 3: liest 1018h:01"),
        (0x583, "4318100192010200", "SDO-Antwort von Knoten 3: ist 1018h:01 = 131474 (00020192h)"),
        (0x583, "6017100000000000", "SDO-Antwort von Knoten 3: geschrieben 1017h:00"),
        (0x183, "1234", "TPDO1 von Knoten 3: 12 34"),
    ],
)
def test_a_canopen_frame_is_decoded_in_german(identifier: int, data: str, expected: str) -> None:
    assert german(canopen_text(Frame(identifier, bytes.fromhex(data)))) == expected


def test_every_part_of_the_evidence_table_has_german() -> None:
    known = {english for english, _ in read_texts("evidence").pairs()}
    shown_there = {plain(str(table[key])) for table in read_evidence() if _parts(table) for key in ("what", "by")}
    assert not shown_there - known, "configs/texts/evidence.toml lacks them"
    assert german("line plc1: 3964R") == "Leitung plc1: 3964R"


def test_refusals_of_the_page_have_german() -> None:
    missing = []
    for path in sorted((GATEWAY / "web").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("Denied", "StoreError", "NotYours"):
                words = [
                    shown(each)
                    for each in node.args
                    if isinstance(each, ast.JoinedStr | ast.Constant) and not isinstance(getattr(each, "value", ""), int)
                ]
                missing += [f"{path.name}:{node.lineno}: {each}" for each in words if german(each) == each]
    assert not missing, missing
    assert german("role setter required; logged in: bert, operator") == "nötig ist die Rolle Einrichter; angemeldet: bert, Bediener"
    assert german("5 characters: String should have at least 10 characters") == "5 characters: mindestens 10 Zeichen"


def test_each_table_keeps_its_fields_and_no_sentence_twice() -> None:
    for name in ("journal", "decoded", "refusals", "evidence"):
        pairs = list(read_texts(name).pairs())
        assert len({english for english, _ in pairs}) == len(pairs)
        for english, said in pairs:
            fields = [{part for part in "0123" if "{" + part + "}" in words} for words in (english, said)]
            assert fields[0] == fields[1], english
            assert english != said or english in SAME or not any(word.islower() and len(word) > 3 for word in english.split()), english


def test_the_most_particular_sentence_wins_and_nothing_runs_away() -> None:
    spoken = Spoken([("{0} is {1}", "{0} ist {1}"), ("{0} is refused", "{0} wird abgelehnt")])
    assert spoken.german("A is refused") == "A wird abgelehnt" and spoken.german("A is B") == "A ist B"
    assert spoken.german("; ".join(["x"] * 5000)) == "; ".join(["x"] * 5000)
