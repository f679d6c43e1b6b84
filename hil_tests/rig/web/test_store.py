"""Users, sessions, tokens and the chained audit (AX-474), in a real SQLite file."""

import pathlib
import sqlite3
import stat
from collections.abc import Iterator

import pytest

from gateway.web.access import Patience, host_of, is_local
from gateway.web.store import Role, Store, StoreError

GOOD = "long enough 1"


@pytest.fixture
def store(tmp_path: pathlib.Path) -> Iterator[Store]:
    made = Store(tmp_path / "web" / "cell.sqlite")
    yield made
    made.close()


def test_there_is_no_default_user_and_a_password_is_kept_as_argon2_only(store: Store) -> None:
    assert store.fresh
    assert not store.right("admin", "admin")
    store.put_user("anna", Role.ADMIN, GOOD)
    assert not store.fresh
    assert store.right("anna", GOOD)
    assert not store.right("anna", GOOD + " ")
    assert stat.S_IMODE(store.path.stat().st_mode) == 0o600
    kept = sqlite3.connect(store.path).execute("select hash from user").fetchone()[0]
    assert kept.startswith("$argon2id$")
    assert GOOD.encode() not in store.path.read_bytes()


def test_weak_passwords_and_the_last_administrator_are_refused(store: Store) -> None:
    for name, password in (("anna", "short"), ("longlonglong", "LongLongLong")):
        with pytest.raises(StoreError):
            store.put_user(name, Role.ADMIN, password)
    store.put_user("anna", Role.ADMIN, GOOD)
    with pytest.raises(StoreError, match="only administrator"):
        store.put_user("anna", Role.VIEWER, GOOD)
    with pytest.raises(StoreError, match="only administrator"):
        store.drop_user("anna")
    store.put_user("otto", Role.ADMIN, GOOD)
    assert store.drop_user("anna")
    assert not store.drop_user("anna")


def test_a_session_ends_with_its_user_its_password_and_its_logout(store: Store) -> None:
    store.put_user("anna", Role.ADMIN, GOOD)
    store.put_user("vera", Role.VIEWER, GOOD)
    first, second = store.open_session("vera"), store.open_session("vera")
    found = store.session(first.id)
    assert found is not None
    assert (found.name, found.role, found.csrf) == ("vera", Role.VIEWER, first.csrf)
    assert first.id.encode() not in store.path.read_bytes(), "only its hash is kept"
    store.close_session(first.id)
    assert store.session(first.id) is None
    assert store.session(second.id) is not None
    store.put_user("vera", Role.OPERATOR, GOOD)
    assert store.session(second.id) is None, "a new password ends what the old one opened"
    assert store.session("") is None


def test_a_token_is_known_until_it_is_dropped(store: Store) -> None:
    secret = store.put_token("script", Role.OPERATOR)
    assert store.token(secret) == ("script", Role.OPERATOR)
    assert store.token(secret + "x") is None
    with pytest.raises(StoreError):
        store.put_token("script", Role.VIEWER)
    assert store.drop_token("script")
    assert store.token(secret) is None


def test_the_audit_is_a_chain_that_shows_what_was_changed_or_taken_out(store: Store) -> None:
    for n in range(5):
        store.note("anna", "127.0.0.1", "POST /api/force", {"bit": n})
    assert store.verify() is None
    assert [entry["number"] for entry in store.audit(2)] == [5, 4]
    other = sqlite3.connect(store.path)
    other.execute("update audit set detail = ? where number = 3", ('{"bit": 9}',))
    other.commit()
    assert store.verify() == 3
    other.execute("update audit set detail = ? where number = 3", ('{"bit": 2}',))
    other.execute("delete from audit where number = 2")
    other.commit()
    assert store.verify() == 2


def test_what_was_stored_survives_a_restart(tmp_path: pathlib.Path) -> None:
    first = Store(tmp_path / "cell.sqlite")
    first.put_user("anna", Role.ADMIN, GOOD)
    first.note("anna", "::1", "x")
    session = first.open_session("anna")
    first.close()
    second = Store(tmp_path / "cell.sqlite")
    assert second.session(session.id) is not None
    second.note("anna", "::1", "y")
    assert second.verify() is None
    second.close()


def test_five_wrong_passwords_have_to_wait_and_others_do_not() -> None:
    patience = Patience()
    for _ in range(5):
        assert patience.wait_s("address a") == 0.0
        patience.wrong("address a", "name n")
    assert 0.0 < patience.wait_s("address a") <= 60.0
    assert patience.wait_s("address b", "name n") > 0.0
    assert patience.wait_s("address b") == 0.0


@pytest.mark.parametrize(
    "header, host", [("localhost:8480", "localhost"), ("[::1]:8480", "::1"), ("10.0.0.7", "10.0.0.7"), ("a.b:1", "a.b")]
)
def test_the_host_of_a_header(header: str, host: str) -> None:
    assert host_of(header) == host


@pytest.mark.parametrize(
    "address, local", [("127.0.0.1", True), ("127.8.0.1", True), ("::1", True), ("10.0.0.1", False), ("testclient", False)]
)
def test_who_sits_at_the_gateway(address: str, local: bool) -> None:
    assert is_local(address) is local


def pages(store: Store) -> int:
    return int(store._db.execute("pragma page_count").fetchone()[0])


def test_a_full_disk_keeps_entries_waiting_and_the_chain_whole(tmp_path: pathlib.Path) -> None:
    """SQLite itself says that the disk is full."""
    told: list[str] = []
    store = Store(tmp_path / "cell.sqlite", told.append)
    store.note("anna", "local", "before")
    store._db.execute(f"pragma max_page_count = {pages(store)}")
    for n in range(40):
        store.note("anna", "local", "POST /api/stop", "x" * 2000 + str(n))
    assert len(told) == 1 and "is not written (database or disk is full); orders are carried out" in told[0]
    with pytest.raises(StoreError, match=r"it cannot be stored \(database or disk is full\); free space on the disk of"):
        store.put_token("x" * 20_000, Role.VIEWER)
    assert store.verify() is None, "what is there is whole"
    store.settle()
    assert len(told) == 1, "nothing is reported while it is full"
    store._db.execute("pragma max_page_count = 100000")
    store.settle()
    assert len(told) == 2 and "is written again; " in told[1] and "0 are lost" in told[1]
    entries = [row for row in store.audit(100) if row["what"] == "POST /api/stop"]
    assert [str(row["detail"])[2000:] for row in entries] == [str(n) for n in reversed(range(40))], "all of them, in their order"
    assert store.verify() is None
    store.note("anna", "local", "after")
    assert store.audit(1)[0]["what"] == "after" and store.verify() is None
    store.close()


def test_what_no_room_is_left_for_is_counted_in_the_chain_itself(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gateway.web.store.MOST_WAITING", 5)
    store = Store(tmp_path / "cell.sqlite")
    store._db.execute(f"pragma max_page_count = {pages(store)}")
    for n in range(12):
        store.note("anna", "local", "order", "x" * 5000 + str(n))
    store._db.execute("pragma max_page_count = 100000")
    store.settle()
    newest = store.audit(1)[0]
    waiting = sum(row["what"] == "order" for row in store.audit(100))
    assert newest["what"] == "audit" and newest["detail"] == f"{12 - waiting} entries were lost: the disk took nothing"
    assert store.verify() is None
    store.close()
