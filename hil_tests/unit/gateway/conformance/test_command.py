"""`axisgate conformance` from end to end with machines in virtual time: files, JSON, exit codes, reports."""

import errno
import json
import os
import pathlib
import shutil
import subprocess
import sys
from typing import Any

import pytest

import gateway
from gateway.commands.conformance import main
from gateway.conformance.reporting.document import checksum
from gateway.conformance.reporting.folder import BadReport, load, verify
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.purpose import selected, unknown

BENCHES = pathlib.Path(gateway.__file__).parents[1] / "configs" / "conformance"
DEVICE = """
from gateway.conformance.peers.stations import Built
def good(): return Built()
def raises(): raise RuntimeError("no power")
def nothing(): return object()
class Dies(Built):
    def receive(self, data, now):
        if data == b"\\x55": raise RuntimeError("stack overflow")
        return super().receive(data, now)
def dies(): return Dies()
"""


def bench(folder: pathlib.Path, factory: str, more: str = "") -> pathlib.Path:
    (folder / "device.py").write_text(DEVICE)
    path = folder / "bench.toml"
    path.write_text(f'[port]\nurl = "machine:device.py:{factory}"\n[link]\nprofile = "rho3"\npriority = "low"\n{more}')
    return path


def run(capsys: pytest.CaptureFixture[str], *argv: object) -> tuple[int, dict[str, Any], str]:
    code = main(["run", *map(str, argv), "--json"])
    out, err = capsys.readouterr()
    return code, json.loads(out) if out else {}, err


@pytest.mark.parametrize(
    ("name", "selects"),
    [
        ("3964R_RCV_BV_0[1-3]", ["3964R_RCV_BV_01", "3964R_RCV_BV_02", "3964R_RCV_BV_03"]),
        ("3964r_rcv_bv_0?", [f"3964R_RCV_BV_0{n}" for n in range(1, 10)]),
        ("3964R_RCV_BV_01", ["3964R_RCV_BV_01"]),
        ("3964R_RCV_BV_[", []),
    ],
)
def test_cases_are_selected_by_a_glob_as_a_shell_knows_it(name: str, selects: list[str]) -> None:
    purposes = SUITES["3964r"].purposes()
    assert [each.id for each in selected(purposes, [name])] == selects
    assert unknown(purposes, [name]) == ([] if selects else [name])


def test_the_json_has_all_fields_of_format_1(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found, progress = run(capsys, "3964r", "--bench", bench(tmp_path, "good"), "--only", "3964R_RCV_*")
    assert code == 0 and "PASS" in progress
    assert found["kind"] == "axisgate conformance" and found["format"] == 1
    wanted = "suite bench pics seed versions self_check counts cases coverage sha256"
    assert set(wanted.split()) <= set(found)
    assert set(found["suite"]) == {"name", "version", "killed", "mutants"}
    fields = "id group role summary clause requirements verdict reason expected got measures host_late_ms caused_by waived trace took_ms"
    for case in found["cases"]:
        assert set(fields.split()) <= set(case)
    measure = next(case for case in found["cases"] if case["id"] == "3964R_RCV_TI_01")["measures"][-1]
    assert set(measure) == {"what", "ms", "min_ms", "max_ms", "uncertainty_ms", "clock"} and measure["clock"] == "virtual"
    assert found["coverage"]["RHO-SER-06"]["verdict"] == "PASS"
    assert found["sha256"] == checksum(found)


@pytest.mark.parametrize(
    "peer, suite, expected, code",
    [
        ("good", "3964r", set(), 0),
        ("good", "rk512", set(), 0),
        ("silent", "3964r", {"3964R_RCV_BV_01"}, 1),
        ("silent", "rk512", {"RK512_PAS_BV_01"}, 1),
        ("slow", "3964r", {"3964R_RCV_BV_01"}, 1),
        ("drops-its-job", "3964r", {"3964R_CON_BV_02"}, 1),
        ("modbus-tcp", "modbus-tcp", set(), 0),
        ("modbus-rtu", "modbus-rtu", set(), 0),
        ("canopen", "canopen-301", set(), 0),
        ("canopen", "cia402", set(), 0),
        ("cia402-no-limits", "cia402", {"CIA402_POS_BI_02", "CIA402_POS_BI_03", "CIA402_CSP_BI_01", "CIA402_CSP_BI_02"}, 1),
        ("canopen-no-sync", "canopen-301", {"CO301_PDO_BV_01", "CO301_PDO_BV_09"}, 1),
    ],
)
def test_an_example_peer_gets_the_fails_of_the_guide(
    peer: str, suite: str, expected: set[str], code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    got, found, _ = run(capsys, suite, "--bench", BENCHES / f"{peer}.toml")
    failed = [case for case in found["cases"] if case["verdict"] == "FAIL"]
    assert got == code and {case["id"] for case in failed} == expected
    assert all(case["expected"] and case["got"] and case["reason"] for case in failed)


def test_sim_is_the_emulated_device_of_the_suite(capsys: pytest.CaptureFixture[str]) -> None:
    for suite, only in (
        ("canopen-301", "CO301_SDO_BV_*"),
        ("cia402", "CIA402_PWR_*"),
        ("3964r", "3964R_RCV_BV_0*"),
        ("modbus-tcp", "MBTCP_FUN_BV_*"),
    ):
        assert main(["run", suite, "--port", "sim", "--only", only]) == 0
        assert " FAIL " not in capsys.readouterr().out


def test_frames_of_a_case_are_a_capture_of_can(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found, _ = run(capsys, "canopen-301", "--port", "sim", "--only", "CO301_SDO_BV_01", "--report", tmp_path / "out")
    assert code == 0 and "< 581#4300100092010200" in found["cases"][0]["trace"]
    capture = (tmp_path / "out" / "traces" / "CO301_SDO_BV_01.pcapng").read_bytes()
    assert b"\xe3\x00\x00\x00" in capture[:120]  # link type 227, CAN_SOCKETCAN
    assert bytes.fromhex("4300100092010200") in capture


def test_a_machine_of_frames_that_gives_no_pair_has_died(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "device.py").write_text(
        "class D:\n def receive(self, frames, now): self.said = [0x581]\n said = []\n def wake(self, now): pass\n"
        " def deadline(self): return None\n def take_output(self): return self.said\n"
        " def sent(self, now): pass\n def lost(self, now): pass\n"
    )
    code, found, _ = run(capsys, "canopen-301", "--port", f"machine:{tmp_path}/device.py:D")
    failed = [case for case in found["cases"] if case["verdict"] == "FAIL"]
    assert code == 1 and len(failed) == 1 and "a pair (identifier, data" in failed[0]["reason"]


def test_no_nak_fails_where_a_refusal_is_due(capsys: pytest.CaptureFixture[str]) -> None:
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "no-nak.toml")
    verdicts = {case["id"]: case for case in found["cases"]}
    assert code == 1 and found["counts"]["FAIL"] <= 12
    assert {"3964R_RCV_BI_01", "3964R_RCV_TI_01", "3964R_SND_BI_01"} <= {
        name for name, case in verdicts.items() if case["verdict"] == "FAIL"
    }
    assert verdicts["3964R_RCV_BI_04"]["verdict"] == "INCONC" and verdicts["3964R_RCV_BI_04"]["caused_by"] == "3964R_RCV_BI_01"


def test_a_device_that_dies_fails_that_case_and_is_reported(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found, _ = run(capsys, "3964r", "--bench", bench(tmp_path, "dies"))
    failed = [case for case in found["cases"] if case["verdict"] == "FAIL"]
    assert code == 1 and len(failed) == 1
    assert "stack overflow" in failed[0]["reason"] and failed[0]["trace"]
    assert all(case["caused_by"] == failed[0]["id"] for case in found["cases"] if case["verdict"] == "INCONC")


def test_all_faults_of_a_bench_come_in_one_run(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bench.toml"
    path.write_text(
        '[port]\nurl = 5\n[link]\nprofil = "rho3"\npriority = "middle"\n[touch]\ndb = [300]\n[known]\n"DB10.DW3" = "xy"\n[spare]\n'
    )
    assert main(["run", "3964r", "--bench", str(path)]) == 2
    said = capsys.readouterr().err
    for key in (
        "port.url",
        "link.profil",
        "did you mean profile",
        "link.priority",
        "high, low",
        "touch.db",
        "0 to 255",
        "DB10.DW3",
        "[spare]",
    ):
        assert key in said
    assert all(str(path) in line for line in said.splitlines())


@pytest.mark.parametrize(
    "factory, words",
    [
        ("raises", "raised RuntimeError: no power"),
        ("nothing", "lacks receive"),
        ("absent", "has no function absent"),
        ("good?x=1", "raised TypeError"),
    ],
)
def test_a_factory_that_gives_no_device_is_a_fault_of_the_file(
    factory: str, words: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "3964r", "--bench", str(bench(tmp_path, factory))]) == 2
    assert words in capsys.readouterr().err


def test_waivers_are_beside_the_verdict_and_expired_ones_are_refused(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    row = '[[waiver]]\nid = "{}"\nreason = "known"\nwho = "lab"\nuntil = {}\n'
    good, old = tmp_path / "good.toml", tmp_path / "old.toml"
    good.write_text(row.format("3964R_CON_BV_02", "2099-12-31"))
    old.write_text(row.format("3964R_CON_BV_02", "2020-01-01") + row.format("3964R_CON_BV_99", "2099-01-01"))
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "drops-its-job.toml", "--waivers", good)
    case = next(case for case in found["cases"] if case["id"] == "3964R_CON_BV_02")
    assert code == 0 and case["verdict"] == "FAIL" and case["waived"]["who"] == "lab"
    assert main(["run", "3964r", "--bench", str(BENCHES / "good.toml"), "--waivers", str(old)]) == 2
    said = capsys.readouterr().err
    assert "expired on 2020-01-01" in said and "3964R_CON_BV_99 is in no case" in said


def test_a_report_is_whole_and_any_changed_byte_is_found(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "report"
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "no-nak.toml", "--report", folder)
    assert code == 1 and load(folder)["sha256"] == found["sha256"]
    page = (folder / "report.html").read_text()
    assert "page 1 of" in page and found["sha256"] in page and "http" not in page.replace("http-equiv", "")
    assert "<failure" in (folder / "junit.xml").read_text()
    assert (folder / "traces" / "3964R_RCV_BI_01.pcapng").read_bytes()[:4] == b"\x0a\x0d\x0d\x0a"
    assert verify(folder) == []
    for name in ("report.json", "report.html", "junit.xml", "traces/3964R_RCV_BI_01.txt"):
        copy = tmp_path / "copy"
        shutil.copytree(folder, copy)
        content = bytearray((copy / name).read_bytes())
        content[len(content) // 2] ^= 1
        (copy / name).write_bytes(content)
        assert any(name in fault for fault in verify(copy))
        capsys.readouterr()
        assert main(["verify", str(copy), "--json"]) == main(["verify", str(copy)]) == 1
        said = json.loads(capsys.readouterr().out.splitlines()[0])
        assert said == {"folder": str(copy), "faults": verify(copy)}
        shutil.rmtree(copy)
    sums = (folder / "SHA256SUMS").read_bytes()
    for end in (b"\x0b", b"\r", b""):
        (folder / "SHA256SUMS").write_bytes(sums[:-1] + end)
        assert any("SHA256SUMS" in fault for fault in verify(folder))
    with pytest.raises(BadReport):
        verify(tmp_path)


def test_a_second_report_in_the_same_folder_is_whole(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Traces of the first one that the second one lacks are gone."""
    folder = tmp_path / "report"
    for more in ((), ("--only", "TI")):
        run(capsys, "3964r", "--bench", BENCHES / "good.toml", "--report", folder, *more)
        assert verify(folder) == []


@pytest.mark.parametrize("full", ["report.json", "SHA256SUMS"])
def test_a_full_disk_leaves_no_half_of_a_file(
    full: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The verdicts are shown, the exit code is 3, and `verify` does not take what is left for a report."""
    folder, write = tmp_path / "report", pathlib.Path.write_bytes
    arguments = ["run", "3964r", "--bench", str(BENCHES / "good.toml"), "--report", str(folder)]
    assert main(arguments) == 0

    def no_room(path: pathlib.Path, content: bytes) -> int:
        if path.name.startswith(full):
            write(path, content[:50])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, content)

    monkeypatch.setattr(pathlib.Path, "write_bytes", no_room)
    capsys.readouterr()
    assert main(arguments) == 3
    said = capsys.readouterr()
    assert "102 PASS" in said.out
    assert said.err == f"axisgate conformance: the report cannot be written to {folder}: No space left on device\n"
    assert not list(folder.rglob("*.part"))
    counts = load(folder)["counts"]
    assert isinstance(counts, dict) and counts["PASS"] == 102
    with pytest.raises(BadReport, match="SHA256SUMS: cannot be read \\(No such file or directory\\)"):
        verify(folder)


def test_json_for_a_full_disk_is_one_sentence_and_the_report_is_there(tmp_path: pathlib.Path) -> None:
    command = [sys.executable, "-m", "gateway", "conformance", "run", "3964r", "--bench", str(BENCHES / "good.toml"), "--json"]
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*command, "--report", str(tmp_path)], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    said = [line for line in done.stderr.splitlines() if not line.startswith("[")]
    wanted = "axisgate conformance: the JSON cannot be written to standard output: No space left on device"
    assert done.returncode == 3 and wanted in said and "Traceback" not in done.stderr
    assert verify(tmp_path) == []


def test_reports_of_two_suites_are_not_compared(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [tmp_path / f"{suite}.json" for suite in ("3964r", "rk512")]
    for path in paths:
        _, found, _ = run(capsys, path.stem, "--bench", BENCHES / "good.toml", "--only", "BV")
        path.write_text(json.dumps(found))
    assert main(["compare", *map(str, paths)]) == 2
    assert "3964r" in (said := capsys.readouterr().err) and "rk512: nothing can be compared" in said
    assert main(["run", "3964r", "--bench", str(BENCHES / "good.toml"), "--failed-from", str(paths[1])]) == 2
    assert "is a report of the suite rk512, not of 3964r" in capsys.readouterr().err


def test_what_two_reports_do_not_share_is_reported(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Another version of the suite, and a case that the suite no longer has."""
    _, found, _ = run(capsys, "3964r", "--bench", BENCHES / "no-nak.toml", "--only", "3964R_RCV_BI_01")
    gone = {**found["cases"][0], "id": "3964R_RCV_BI_90"}
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    old.write_text(json.dumps({**found, "suite": {**found["suite"], "version": "0.9"}, "cases": [*found["cases"], gone]}))
    new.write_text(json.dumps(found))
    assert main(["compare", str(old), str(new)]) == 0
    assert "old.json is of version 0.9 of the suite" in capsys.readouterr().err
    _, again, said = run(capsys, "3964r", "--bench", BENCHES / "no-nak.toml", "--failed-from", old)
    assert [case["id"] for case in again["cases"]] == ["3964R_RCV_BI_01"] and "no longer has 3964R_RCV_BI_90" in said


def test_a_waiver_that_is_not_needed_is_named(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    waivers = tmp_path / "waivers.toml"
    waivers.write_text('[[waiver]]\nid = "3964R_RCV_BV_02"\nreason = "known"\nwho = "lab"\nuntil = 2099-12-31\n')
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "good.toml", "--waivers", waivers, "--only", "3964R_RCV_BV_02")
    assert code == 0 and "waiver of 3964R_RCV_BV_02: not needed, the case passed" in found["pics"]["assumed"]


def test_a_pics_that_exists_is_not_overwritten(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    pics = tmp_path / "pics.toml"
    pics.write_text("entered by hand")
    assert main(["new-pics", "rk512", "--port", "sim", "--output", str(pics)]) == 2
    assert "name another file" in capsys.readouterr().err and pics.read_text() == "entered by hand"


def test_the_page_is_german_where_it_is_wanted(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "3964r", "--bench", str(BENCHES / "silent.toml"), "--report", str(tmp_path / "r"), "--language", "de", "--only", "BV"])
    page = (tmp_path / "r" / "report.html").read_text()
    assert "Konformitätsbericht" in page and "Seite 1 von" in page and "STX in Ruhe" in page
    assert ">Hersteller<" in page and ">Seriennummer<" in page
    assert "FAIL" in capsys.readouterr().out


def test_failed_from_only_and_compare(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    for name, path in (("drops-its-job", old), ("good", new)):
        _, found, _ = run(capsys, "3964r", "--bench", BENCHES / f"{name}.toml")
        path.write_text(json.dumps(found))
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "good.toml", "--failed-from", old)
    behind = ["3964R_CON_BO_02", "3964R_CON_ST_01", "3964R_CON_BV_04", "3964R_CON_BI_02", "3964R_CON_RC_01"]
    assert code == 0 and [case["id"] for case in found["cases"]] == ["3964R_CON_BV_02", *behind]
    part = tmp_path / "part.json"
    part.write_text(json.dumps(found))
    capsys.readouterr()
    assert main(["compare", str(old), str(part)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in said[:6]] == ["3964R_CON_BV_02", *behind] and said[6] == "6 verdicts differ"
    assert said[7:] == [f"only in {old}: 103 of the cases"]
    assert main(["compare", str(old), str(new)]) == 0
    assert main(["compare", str(new), str(old)]) == 1
    assert "3964R_CON_BV_02" in capsys.readouterr().out
    assert main(["run", "3964r", "--bench", str(BENCHES / "good.toml"), "--failed-from", str(new)]) == 2
    assert main(["run", "3964r", "--bench", str(BENCHES / "good.toml"), "--only", "3964R_RCV_BV_99"]) == 2
    assert "did you mean" in capsys.readouterr().err


def test_a_dry_run_opens_nothing(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bench.toml"
    path.write_text('[port]\nurl = "/dev/nothing-here"\n[pics]\nblock_check = false\n')
    assert main(["run", "3964r", "--bench", str(path), "--dry-run"]) == 0
    said = capsys.readouterr().out
    assert "N/A  3964R_RCV_BI_01" in said and "nothing was opened" in said


def test_ctrl_c_reports_what_was_done(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from gateway.tools.conformance import run as module

    seen = []

    def progress(*arguments: object) -> None:
        seen.append(arguments)
        if len(seen) == 5:
            raise KeyboardInterrupt

    monkeypatch.setattr(module, "_progress", progress)
    code, found, _ = run(capsys, "3964r", "--bench", BENCHES / "good.toml")
    assert code == 3 and found["interrupted"]
    assert sum(case["verdict"] == "PASS" for case in found["cases"]) >= 4
    assert all("interrupted" in case["reason"] for case in found["cases"] if case["verdict"] == "INCONC")


def test_it_runs_where_no_module_of_linux_is(tmp_path: pathlib.Path) -> None:
    """As on Windows: machines and COM ports need none of them."""
    program = (
        "import sys\n"
        "for name in ('fcntl', 'termios', 'pty', 'tty', 'resource', 'gpiod', 'grp', 'pwd'): sys.modules[name] = None\n"
        "from gateway.commands.conformance import main\n"
        f"sys.exit(main(['run', 'rk512', '--bench', r'{BENCHES / 'good.toml'}', '--only', 'BV']))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
