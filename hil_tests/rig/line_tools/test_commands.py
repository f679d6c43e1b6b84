"""The command line of the tools: exit codes, files, lists, words."""

import json
import pathlib

from hil_tests.rig.line_tools.conftest import axisgate

DEVICE = """
[device]
name = "Checkweigher CW-4"
serial = "4711"
[link]
port = "sim:good,siemens-cp341,low"
profile = "siemens-cp341"
priority_of_device = "low"
[stimulus]
how = "none"
"""


def test_the_bad_partner_ends_with_a_report_that_has_a_fail_and_its_reason(tmp_path: pathlib.Path) -> None:
    done = axisgate("line", "probe", "sim:bad-partner", "--report", "bad", folder=tmp_path)
    assert done.returncode == 1
    assert "2 connection attempts, expected 6" in done.stdout
    assert "2 connection attempts, expected 6" in (tmp_path / "bad.html").read_text()
    assert json.loads((tmp_path / "bad.json").read_text())["counts"]["FAIL"] >= 4


def test_the_list_and_a_name_that_is_not_in_it(tmp_path: pathlib.Path) -> None:
    listed = axisgate("line", "probe", "--list", folder=tmp_path)
    assert listed.returncode == 0
    assert len(listed.stdout.splitlines()) >= 75
    wrong = axisgate("line", "probe", "sim:good", "--only", "nothing", folder=tmp_path)
    assert wrong.returncode == 2
    assert "no such test; --list shows them" in wrong.stderr


def test_a_device_file_replaces_options(tmp_path: pathlib.Path) -> None:
    (tmp_path / "cw4.toml").write_text(DEVICE)
    done = axisgate(
        "line",
        "probe",
        "--device",
        "cw4.toml",
        "--only",
        "receive.length-1",
        "--only",
        "send.good",
        "--json",
        "--no-report",
        folder=tmp_path,
    )
    report = json.loads(done.stdout)
    assert done.returncode == 0
    assert report["device"]["name"] == "Checkweigher CW-4"
    assert report["profile"]["name"] == "siemens-cp341"
    assert {test["name"]: test["verdict"] for test in report["tests"]} == {"receive.length-1": "PASS", "send.good": "NOT RUN"}


def test_semicolons_in_a_device_file_get_a_hint(tmp_path: pathlib.Path) -> None:
    (tmp_path / "cw4.toml").write_text('[device]\nname = "Checkweigher CW-4"; serial = "4711"\n')
    done = axisgate("line", "probe", "--device", "cw4.toml", folder=tmp_path)
    assert done.returncode == 2
    assert "TOML needs one key per line, without semicolons" in done.stderr


def test_usage_faults_are_exit_2_and_say_what_was_expected(tmp_path: pathlib.Path) -> None:
    for words, expected in (
        (("fetch", "sim:nobody", "DB1.DW0"), "partners are good, raw, bad-partner"),
        (("fetch", "sim:good", "DB10.DW0", "--format", "fast"), '"9600 8E1"'),
        (("fetch", "sim:good", "DB10.DW0", "--type", "FLOAT"), "an S5 float is KG"),
        (("monitor",), "PORT, --tap A,B (two ports) or --record FILE expected"),
        (("diagnose", "--pafe", "XYZ"), "hexadecimal 0..FF expected"),
        (("learn", __file__), "neither a line record nor a journal"),
    ):
        done = axisgate("line", *words, folder=tmp_path)
        assert done.returncode == 2, (words, done.stderr)
        assert expected in done.stderr, done.stderr
        assert "Traceback" not in done.stderr


def test_diagnose_ends_with_1_when_something_is_wrong(tmp_path: pathlib.Path) -> None:
    assert axisgate("line", "diagnose", "sim:good", folder=tmp_path).returncode == 0
    echo = axisgate("line", "diagnose", "sim:echo", folder=tmp_path)
    assert (echo.returncode, echo.stdout.split(":")[0]) == (1, "fault  echo")
