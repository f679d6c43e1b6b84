"""`axisgate web user`: the page's users from the command line, in the very file the page reads."""

import io
import json
import os
import pathlib
import pty
import stat
import sys

import pytest

from gateway.cell_file.load import load_cell
from gateway.commands.web import main
from gateway.runtime.page_data import data_file
from gateway.web.store import Role, Store

GOOD, BETTER = "correct horse 7", "battery staple 9"
CELL = 'format = 1\n[cell]\nname = "c"\n[web]\n'


@pytest.fixture
def cell(tmp_path: pathlib.Path) -> str:
    path = tmp_path / "cell.toml"
    path.write_text(CELL)
    return str(path)


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> "Typed":
    return Typed(monkeypatch)


class Typed:
    """What comes through the pipe."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._monkeypatch = monkeypatch

    def __call__(self, words: str) -> None:
        self._monkeypatch.setattr(sys, "stdin", io.StringIO(words))


def opened(cell: str) -> Store:
    loaded = load_cell(cell)
    assert loaded.web is not None
    return Store(data_file(loaded, loaded.web, simulated=False))


def test_users_are_added_listed_changed_and_removed(cell: str, typed: Typed, capsys: pytest.CaptureFixture[str]) -> None:
    typed(f"{GOOD}\n")
    assert main(["user", "add", cell, "anna", "--role", "admin", "--stdin"]) == 0
    typed(BETTER)
    assert main(["user", "add", cell, "bert", "--role", "viewer", "--stdin"]) == 0
    store = opened(cell)
    assert store.users() == [("anna", Role.ADMIN), ("bert", Role.VIEWER)] and store.right("anna", GOOD) and store.right("bert", BETTER)
    assert stat.S_IMODE(store.path.stat().st_mode) == 0o600
    session = store.open_session("bert")
    typed(GOOD)
    assert main(["user", "password", cell, "bert", "--stdin"]) == 0
    assert store.right("bert", GOOD) and not store.right("bert", BETTER) and store.session(session.id) is None
    assert dict(store.users())["bert"] is Role.VIEWER, "a new password keeps the role"
    capsys.readouterr()
    assert main(["user", "list", cell, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == {"file": str(store.path), "users": [{"name": "anna", "role": "admin"}, {"name": "bert", "role": "viewer"}]}
    assert main(["user", "remove", cell, "bert"]) == 0
    assert store.users() == [("anna", Role.ADMIN)]
    assert [entry["what"] for entry in store.audit()] == [f"web user {what}" for what in ("remove", "password", "add", "add")]
    assert store.verify() is None and GOOD not in json.dumps(store.audit())
    store.close()


@pytest.mark.parametrize(
    ("words", "piped", "said"),
    [
        (["add", "anna", "--role", "viewer", "--stdin"], GOOD, "exists already; next: axisgate web user password"),
        (["add", "bert", "--role", "viewer", "--stdin"], "short", "10 characters or more"),
        (["add", "bert", "--role", "viewer", "--stdin"], "", "10 characters or more"),
        (["remove", "anna"], "", "is the only administrator"),
        (["remove", "bert"], "", "no user bert; there are anna"),
        (["password", "bert", "--stdin"], GOOD, "no user bert"),
    ],
)
def test_what_is_refused_changes_nothing(
    cell: str, typed: Typed, capsys: pytest.CaptureFixture[str], words: list[str], piped: str, said: str
) -> None:
    typed(GOOD)
    assert main(["user", "add", cell, "anna", "--role", "admin", "--stdin"]) == 0
    typed(piped)
    assert main(["user", words[0], cell, *words[1:]]) == 1
    assert said in capsys.readouterr().err
    store = opened(cell)
    assert store.users() == [("anna", Role.ADMIN)] and store.right("anna", GOOD) and len(store.audit()) == 1
    store.close()


def test_a_terminal_is_asked_twice_and_shows_nothing(cell: str) -> None:
    pid, fd = pty.fork()
    if pid == 0:
        os.execv(sys.executable, [sys.executable, "-m", "gateway", "web", "user", "add", cell, "anna", "--role", "admin"])
    seen = b""
    for question in (b"password: ", b"once more: "):
        while not seen.endswith(question):
            seen += os.read(fd, 1024)
        os.write(fd, f"{GOOD}\n".encode())
    while b"done" not in seen:
        seen += os.read(fd, 1024)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    os.close(fd)
    assert GOOD.encode() not in seen
    store = opened(cell)
    assert store.right("anna", GOOD)
    store.close()


def test_a_cell_that_is_none_and_a_place_that_cannot_be_written(tmp_path: pathlib.Path, cell: str) -> None:
    assert main(["user", "list", str(tmp_path / "nothing.toml")]) == 2
    (tmp_path / "web").write_text("a file where the folder should be")
    assert main(["user", "list", cell]) == 3
