"""`axisgate val3 check` and `axisgate val3 run` on files of a disk."""

import json
import pathlib

import pytest

from gateway.commands.val3 import main
from hil_tests.unit.languages.val3.apps import App, datum, value

DATA = datum("n", "num") + datum("di", "dio", values=value(link="UserIO\\go"))


def written(tmp_path: pathlib.Path, code: str) -> str:
    """An application in a folder."""
    for path, data in App(data=DATA, programs={"start": code}).files().items():
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    return str(tmp_path / "demo")


def test_check_lists_file_line_column_and_text(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    app = written(tmp_path, "n=1\n  nope=2")
    assert main(["check", app, "--json"]) == 1
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["file"], row["line"], row["column"], row["text"]) == ("demo/start.pgx", 3, 3, "'nope' : data expected")
    assert main(["check", app]) == 1
    assert "(File start.pgx-line 3) 'nope' : data expected" in capsys.readouterr().out


def test_run_prints_the_same_bytes_for_the_same_input(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    app = written(tmp_path, 'wait(di==true)\nn=clock()\npopUpMsg("done")')
    command = ["run", app + "/demo.pjx", "--virtual", "--json", "--at", "1.5", "dio.go=1", "--line-us", "2"]
    assert main(command) == 0
    first = capsys.readouterr().out
    assert main(command) == 0 and capsys.readouterr().out == first
    found = json.loads(first)
    assert list(found) == ["globals", "tasks", "log", "popups", "moves", "end_s"]
    assert found["globals"] == {"n": 1.5, "di": True} and (found["popups"], found["tasks"], found["moves"]) == (["done"], {}, [])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--at", "1", "dio.go"], "seconds from 0 and WHAT=VALUE"),
        (["--at", "x", "n=1"], "a number of seconds"),
        (["--at", "0", "nothing=1"], "there is no global of that name"),
        (["--at", "50", "nothing=1"], "there is no global of that name"),
        (["--at", "0", "mode=fast"], "manual, test, local, remote"),
        (["--at", "50", "mode=fast"], "manual, test, local, remote"),
        (["--at", "50", "n=abc"], "a number, true or false"),
        (["--at", "50", "dio.go=maybe"], "a number, true or false"),
        (["--at", "50", "io.go=loose"], "works, locked"),
        (["--at", "50", "sio.camera=hex:0"], "pairs of hexadecimal digits"),
        (["--at", "50", "page.main.ok=press"], "page.PAGE.OBJECT.ATTRIBUTE=VALUE"),
        (["--at", "50", "estop=7"], "0, 1, 2, 3"),
        (["--at", "50", "joints=1,2"], "one number a joint"),
        (["--at", "50", "key=F1"], "one character or the number of a key"),
        (["--at", "50", "app=start"], "stop are expected"),
        (["--until", "0"], "seconds above 0"),
        (["--line-us", "0"], "0.001 to 1000000"),
        (["--start", "1,2"], "6 numbers"),
        (["--start", "0,0,0,0,0,999"], "outside the travel"),
        (["--start", "0,0,0,0,0,nan"], "outside the travel"),
        (["--disk", "/usr/share"], "is not on the disk"),
    ],
)
def test_bad_input_gets_one_sentence(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str], arguments: list[str], told: str) -> None:
    assert main(["run", written(tmp_path, "delay(1)"), "--virtual", *arguments]) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1


def test_an_application_with_faults_or_without_files_does_not_run(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", written(tmp_path, "nope=1"), "--virtual"]) == 1
    assert "'nope' : data expected" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "none")]) == 2 and "there is no such folder or file" in capsys.readouterr().err


def test_the_arm_is_the_robot_of_a_cell(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    app = written(tmp_path, "n=herej().j4")
    assert main(["check", app, "--cell", "scara"]) == 0 and "0 errors" in capsys.readouterr().out
    assert main(["check", written(tmp_path, "n=herej().j6"), "--cell", "scara"]) == 1
    assert "'j6' : invalid name" in capsys.readouterr().out
    assert main(["check", app, "--cell", "demo"]) == 2 and "give --robot" in capsys.readouterr().err
