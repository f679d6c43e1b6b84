"""Every key of a bench file acts or is refused: the supply, the marks of a pty, the stimulus."""

import datetime
import io
import os
import pathlib
import pty
import socket
import sys
import threading
import tty
from typing import Any

import pytest

from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort
from gateway.commands.conformance import main
from gateway.conformance.framework.bench_file import BadFile, Bench, load_bench, load_waivers
from gateway.conformance.framework.bench_rules import ERRORS, RANGES
from gateway.conformance.framework.power import switch_of
from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Built, Variant, link_of
from gateway.conformance.suites.registry import SUITES
from gateway.conformance.suites.rk512 import refusals
from gateway.pure.conformance.verdict import Inconclusive, Verdict
from hil_tests.unit.gateway.conformance.test_command import BENCHES, run
from protocols.base.machine import Damage
from protocols.p3964r.profiles import RHO3, Priority

PORT = '[port]\nurl = "{}"\n'
FILE = 'import pathlib, sys; pathlib.Path("state").write_text(sys.argv[1])'


def refused(tmp_path: pathlib.Path, text: str, url: str = "/dev/ttyUSB0") -> str:
    path = tmp_path / "bench.toml"
    path.write_text(PORT.format(url) + text)
    with pytest.raises(BadFile) as bad:
        load_bench(path)
    return str(bad.value)


@pytest.mark.parametrize(
    "text, url, says",
    [
        ('[power]\non = ["a"]\n', "/dev/ttyUSB0", "power.off: is missing"),
        ('[power]\nprompt = "x"\nrelay = "tcp://a:1"\n', "/dev/ttyUSB0", "one way to switch"),
        ("[power]\nlimit_ms = 10\n", "/dev/ttyUSB0", "nothing switches"),
        ('[power]\nprompt = "x"\ncoil = 1\n', "/dev/ttyUSB0", "power.coil: acts with relay only"),
        ('[power]\nrelay = "gpio17"\n', "/dev/ttyUSB0", 'an address such as "tcp://10.0.0.5:502"'),
        ('[power]\nprompt = "x"\n', "machine:a.py:b", "power(on, now)"),
        ("marks = true\n", "tcp://a:1", "port.marks: acts at a pty only"),
        ('[stimulus]\nkind = "fetch"\ncoil = 1\n', "/dev/ttyUSB0", 'stimulus.coil: does not act with kind = "fetch"'),
        ('[stimulus]\nkind = "command"\n', "/dev/ttyUSB0", "stimulus.command: is missing"),
        ('[stimulus]\nkind = "modbus"\n', "/dev/ttyUSB0", "stimulus.url: is missing"),
        ('[stimulus]\nprompt = "x"\n', "/dev/ttyUSB0", "stimulus.kind: is missing"),
        ('[report]\nlanguage = "fr"\n', "/dev/ttyUSB0", "one of en, de"),
    ],
)
def test_a_key_that_cannot_act_is_refused(tmp_path: pathlib.Path, text: str, url: str, says: str) -> None:
    assert says in refused(tmp_path, text, url)


def test_a_key_of_another_suite_is_named_in_the_report(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bench.toml"
    path.write_text(
        (BENCHES / "good.toml").read_text().replace("../../gateway", str(BENCHES.parents[1] / "gateway")) + "[known]\n'coil:1' = 1\n"
    )
    _, found, _ = run(capsys, "3964r", "--bench", path, "--only", "3964R_RCV_BV_01")
    assert "known.coil: has no effect in the suite 3964r" in found["pics"]["assumed"]


def bench(tmp_path: pathlib.Path, **power: object) -> Bench:
    return Bench(tmp_path / "bench.toml", "/dev/ttyUSB0", power=power)


def test_the_supply_is_switched_by_commands(tmp_path: pathlib.Path) -> None:
    argv = [sys.executable, "-c", FILE]
    two = switch_of(bench(tmp_path, on=[*argv, "up"], off=[*argv, "down"]), print)
    one = switch_of(bench(tmp_path, command=argv), print)
    assert two is not None and one is not None
    for turn, on, word in ((two, False, "down"), (two, True, "up"), (one, False, "off"), (one, True, "on")):
        turn(on)
        assert (tmp_path / "state").read_text() == word
    wrong = switch_of(bench(tmp_path, command=[sys.executable, "-c", "import sys; sys.exit(3)"]), print)
    slow = switch_of(bench(tmp_path, command=[sys.executable, "-c", "import time; time.sleep(60)"], limit_ms=300), print)
    assert wrong is not None and slow is not None
    with pytest.raises(Inconclusive, match="ended with 3"):
        wrong(True)
    with pytest.raises(Inconclusive, match="timed out"):
        slow(True)


def test_the_supply_is_switched_by_a_relay(tmp_path: pathlib.Path) -> None:
    heard: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            for _ in range(2):
                connection, _ = server.accept()
                with connection:
                    heard.append(connection.recv(64))
                    connection.sendall(heard[-1])

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        turn = switch_of(bench(tmp_path, relay=f"tcp://127.0.0.1:{server.getsockname()[1]}", coil=3, unit=7, inverted=True), print)
        assert turn is not None
        turn(False)
        turn(True)
        thread.join(10)
    assert [one[6:].hex() for one in heard] == ["07050003ff00", "070500030000"]


def test_an_operator_has_a_time_limit(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    turn = switch_of(bench(tmp_path, prompt="Supply of the station", limit_ms=5000), said.append)
    assert turn is not None
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    turn(False)
    assert said == ["Supply of the station: OFF, then press Enter (at most 5 s)"]
    with pytest.raises(Inconclusive, match="no operator"):
        turn(True)


@pytest.mark.parametrize("marks, sent, read", [(None, b"\xff", b"\xff"), (False, b"\xff\xff", b"\xff\xff"), (True, b"\xff\xff", b"\xff")])
def test_marks_decide_what_ff_means_on_a_pty(marks: bool | None, sent: bytes, read: bytes) -> None:
    far, near = pty.openpty()
    try:
        tty.setraw(near)
        port = PtyPort(os.ttyname(near), parse_format("9600 8E1"), marks=marks)
        try:
            os.write(far, sent)
            found: list[bytes | Damage] = []
            while b"".join(one for one in found if isinstance(one, bytes)) != read:
                found += port.read()
        finally:
            port.close()
    finally:
        os.close(far)
        os.close(near)


class Hangs(Powered):
    """Once it has heard a character after NAK it is silent until its supply was switched."""

    def __init__(self) -> None:
        super().__init__(lambda: Built(RHO3, Priority.LOW))
        self.hung = False

    def power(self, on: bool, now: int) -> None:
        self.hung = False
        super().power(on, now)

    def receive(self, data: bytes, now: int) -> Any:
        self.hung = self.hung or data == b"\x16"
        return [] if self.hung else super().receive(data, now)


def test_a_device_that_hangs_is_revived_by_its_supply() -> None:
    """The case that hangs it FAILs; the others are judged, not INCONC."""
    results = play(SUITES["3964r"], Variant("hangs", "", Hangs, link_of(RHO3, Priority.LOW), {}))
    verdicts = [result.verdict for result in results]
    assert fails(results) and Verdict.INCONC not in verdicts
    assert verdicts.count(Verdict.PASS) > 50


def test_faults_of_all_files_come_in_one_run(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each key of [link] times, rules beside single keys, PICS and waivers; a byte order mark of an editor is none."""
    files = {name: tmp_path / f"{name}.toml" for name in ("bench", "pics", "waivers")}
    files["bench"].write_text(
        '\ufeff[port]\nurl = "tcp://host:99999"\nformat = "9600 9X7"\n'
        '[link]\ntimes = { qvz_ms = -5, zvz_ms = "a", connect_attempts = 0, zvs = 1 }\n'
        '[known]\n"input:99999" = 1\n"DB300.DW1" = "0A"\n[power]\non = ["a"]\n[pics]\nrk512 = "maybe"\n',
        encoding="utf-8",
    )
    files["pics"].write_text("[pics]\npassive = 3\n")
    files["waivers"].write_text('[[waiver]]\nid = "3964R_RCV_BV_99"\nreason = "x"\nwho = "x"\nuntil = 2099-01-01\n')
    options = [str(part) for name, path in files.items() for part in (f"--{name}", path)]
    assert main(["run", "3964r", *options]) == 2
    lines = capsys.readouterr().err.splitlines()
    wanted = {
        "bench": (
            "port.url: tcp://host:port with a port number 1 to 65535 expected, found 'tcp://host:99999'",
            "port.format: baud rate, data bits 5..8, parity N|E|O, stop bits 1|2, such as \"9600 8E1\" expected, found '9600 9X7'",
            "link.times.qvz_ms: a number 0 to 3.6e+06",
            "link.times.zvz_ms: a number",
            "link.times.connect_attempts: a whole number 1 to 255",
            "link.times.zvs: no such key",
            'known."input:99999": numbers 0 to 65535',
            'known."DB300.DW1": numbers 0 to 255',
            "power.off: is missing",
            "pics.rk512: true or false",
        ),
        "pics": ("pics.passive: true or false",),
        "waivers": ("waiver 1: id 3964R_RCV_BV_99",),
    }
    for name, texts in wanted.items():
        for text in texts:
            assert any(f"{files[name]}: {text}" in line for line in lines), (text, lines)


def test_all_faults_of_a_waiver_are_named_in_one_run(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "waivers.toml"
    rows = (
        'id = "X_1"\nreason = ""\nwho = "lab"\nuntil = 2020-01-01',
        'id = "A_1"\nreason = "known"\nwho = "lab"\nuntil = 2099-01-01T10:00:00',
        'id = "A_1"\nreason = "known"\nwho = "lab"\nuntil = 2099-01-01\ncolour = 1',
        'id = ["A_1"]\nreason = "known"\nwho = "lab"\nuntil = "soon"',
    )
    path.write_text("".join(f"[[waiver]]\n{row}\n" for row in rows))
    with pytest.raises(BadFile) as raised:
        load_waivers(path, frozenset(("A_1",)), datetime.date(2026, 1, 1))
    said = [line.removeprefix(f"{path}: waiver ") for line in str(raised.value).splitlines()]
    assert [line.split(";")[0] for line in said] == [
        "1: reason missing",
        "1: id X_1 is in no case of this suite",
        "1: X_1 expired on 2020-01-01",
        "3: colour: no such key",
        "3: A_1 is waived above already",
        "4: id ['A_1'] is in no case of this suite",
        "4: until soon: a date such as 2027-06-30 expected",
    ]


def test_numbers_and_error_names_of_the_pics_and_files_of_the_bench(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An unknown name of an error, and a number out of its range, had no effect; a missing EDS was reported alone."""
    bench = tmp_path / "bench.toml"
    bench.write_text(
        '[port]\nurl = "sim"\n[link]\neds = "none.eds"\n[pics]\nmost_received = 0\nwords = 257\n'
        'errors = { missing_blok = "2A", wrong_type = "100", amount_0 = "2A" }\n'
    )
    assert main(["run", "rk512", "--bench", str(bench)]) == 2
    said = capsys.readouterr().err
    for text in (
        f"link.eds: {tmp_path / 'none.eds'} does not exist",
        "pics.most_received: a whole number 1 to 65535 expected, found 0",
        "pics.words: a whole number 1 to 256 expected, found 257",
        "pics.errors.missing_blok: no such error; there are missing_block, ",
        "did you mean missing_block?",
        "pics.errors.wrong_type: an error number in hexadecimal such as \"2A\" expected, found '100'",
    ):
        assert text in said, (text, said)
    assert "amount_0: " not in said


def test_each_whole_number_of_the_pics_has_a_range_and_each_error_a_case() -> None:
    wholes = {question.key for suite in SUITES.values() for question in suite.questions if question.kind == "whole"}
    assert wholes == set(RANGES)
    folder = pathlib.Path(refusals.__file__).parent
    cases = "".join((folder / name).read_text(encoding="utf-8") for name in ("refusals.py", "passive.py"))
    assert [name for name in ERRORS if f'"{name}"' not in cases] == []
