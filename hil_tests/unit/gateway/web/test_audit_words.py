"""The audit in words, English and German: who reads it need not know the interface."""

import json
import re

import pytest

from gateway.web.accounts import Accounts
from gateway.web.api import Api, endpoints
from gateway.web.audit_words import sentences_of

AXES = ("A1", "A2", "A3")


@pytest.mark.parametrize(
    "what, detail, english, german",
    [
        ("POST /api/command", {"code": "enable", "mask": 5, "targets": []}, "switched drives on: A1, A3", "Antriebe eingeschaltet: A1, A3"),
        (
            "POST /api/command",
            {"code": "ptp_absolute", "mask": 2, "targets": [0.0, 12.5]},
            "ordered a move: A2 12.5",
            "Fahrt befohlen: A2 12.5",
        ),
        ("POST /api/command", {"code": "override", "mask": 7, "velocity": 0.25}, "set the override to 25 %", "Override auf 25 % gesetzt"),
        ("POST /api/permit", {"on": False}, "cleared the enabling inputs of the simulation", "Freigaben der Simulation gelöscht"),
        ("POST /api/force", {"bit": 40, "value": 1}, "forced RC input 40 to 1", "RC-Eingang 40 auf 1 gesteuert"),
        ("POST /api/unforce", {"bit": None}, "ended all forces", "alles Steuern beendet"),
        ("POST /api/unforce", {"bit": 40}, "ended the force of RC input 40", "Steuern von RC-Eingang 40 beendet"),
        ("POST /api/users", {"name": "otto", "role": "operator"}, "saved user otto as operator", "Benutzer otto als Bediener gespeichert"),
        ("POST /api/cable", {"line": "plc1", "do": "unplug"}, "pulled the cable of plc1", "Kabel von plc1 gezogen"),
        ("POST /api/stop", {}, "stopped all axes on the path", "alle Achsen auf der Bahn angehalten"),
    ],
)
def test_an_entry_says_what_was_done(what: str, detail: dict[str, object], english: str, german: str) -> None:
    assert sentences_of(what, json.dumps(detail), AXES) == (english, german)


def test_an_entry_nobody_has_words_for_is_reported_as_it_was_kept() -> None:
    assert sentences_of("POST /api/later", '{"a": 1}', AXES) == ('POST /api/later {"a": 1}',) * 2
    assert sentences_of("POST /api/command", "torn {", AXES) == ("POST /api/command torn {",) * 2


def test_every_change_the_interface_takes_has_its_words() -> None:
    class Named(Api):
        def __init__(self) -> None:  # its handlers alone are wanted
            self.accounts = Accounts.__new__(Accounts)

    given = {
        "code": "enable", "on": True, "bit": 3, "do": "unplug", "kind": "watch", "line": "a", "name": "a", "value": "1", "id": "db:10:2",
        "channels": ["a"], "address": "a", "role": "admin", "label": "a", "emulator": "a", "operand": "M 8",
        "act": "set", "what": "n", "run": 3, "how": "into", "program": "a", "point": "p", "lines": [5],
    }  # fmt: skip
    changes = [f"{each.method} {each.path}" for each in endpoints(Named()) if each.changes]
    assert len(changes) > 15
    for what in changes:
        for words in sentences_of(what, json.dumps(given), AXES):
            assert not words.startswith("POST") and not re.search(r"[{}]", words), what
