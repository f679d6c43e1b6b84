"""Text of an audit entry, English and German; the entry itself stays as it was chained."""

import json
from collections.abc import Sequence

Words = tuple[str, str]
CODES: dict[str, Words] = {
    "enable": ("switched drives on", "Antriebe eingeschaltet"),
    "disable": ("switched drives off", "Antriebe ausgeschaltet"),
    "reference": ("ordered a reference run", "Referenzfahrt befohlen"),
    "ptp_absolute": ("ordered a move", "Fahrt befohlen"),
    "ptp_relative": ("ordered a relative move", "relative Fahrt befohlen"),
    "resume": ("resumed the motion", "Bewegung fortgesetzt"),
    "abandon": ("abandoned the rest of the motion", "Rest der Bewegung verworfen"),
    "fault_reset": ("reset faults", "Störungen quittiert"),
    "override": ("set the override to {velocity} %", "Override auf {velocity} % gesetzt"),
    "request_control": ("requested control", "Steuerung angefordert"),
    "release_control": ("released control", "Steuerung abgegeben"),
}
OF_AXES = ("enable", "disable", "reference", "ptp_absolute", "ptp_relative")
ORDERS: dict[str, Words] = {
    "POST /api/stop": ("stopped all axes on the path", "alle Achsen auf der Bahn angehalten"),
    "POST /api/force": ("forced RC input {bit} to {value}", "RC-Eingang {bit} auf {value} gesteuert"),
    "POST /api/force/word": ("forced {id} to {value}", "{id} auf {value} gesteuert"),
    "POST /api/unforce/word": ("ended the force of {id}", "Steuern von {id} beendet"),
    "POST /api/scope/start": ("started a recording of {channels}", "Aufzeichnung von {channels} gestartet"),
    "POST /api/scope/stop": ("ended the recording", "Aufzeichnung beendet"),
    "POST /api/scope/open": ("reopened recording {name}", "Aufzeichnung {name} wieder geöffnet"),
    "POST /api/scope/save": ("kept the recording as {name}", "Aufzeichnung als {name} aufbewahrt"),
    "POST /api/program/start": ("started program {name}", "Programm {name} gestartet"),
    "POST /api/program/test": ("started program {name} in test", "Programm {name} im Test gestartet"),
    "POST /api/program/breakpoints": ("set the breakpoints of {name}: {lines}", "Haltepunkte von {name} gesetzt: {lines}"),
    "POST /api/program/step": ("test of process {run}: {how}", "Test von Prozess {run}: {how}"),
    "POST /api/program/single": ("single step of program {name}: {how}", "Einzelschritt von Programm {name}: {how}"),
    "POST /api/program/movement": ("test with movement: {on}", "Test mit Bewegung: {on}"),
    "POST /api/program/variable": ("set {name} of {program} to {value}", "{name} von {program} auf {value} gesetzt"),
    "POST /api/program/teach": ("taught point {point} of {name}", "Punkt {point} von {name} geteacht"),
    "POST /api/program/define": ("set point {point} of {name} to {value}", "Punkt {point} von {name} auf {value} gesetzt"),
    "POST /api/program/stop": ("stopped program {name}", "Programm {name} gestoppt"),
    "POST /api/val3/act": ("VAL 3: {act} {what} {value}", "VAL 3: {act} {what} {value}"),
    "POST /api/plc/start": ("started PLC program {name}", "SPS-Programm {name} gestartet"),
    "POST /api/plc/stop": ("stopped the PLC", "SPS gestoppt"),
    "POST /api/plc/ack": ("acknowledged the message of the PLC", "Meldung der SPS quittiert"),
    "POST /api/plc/write": ("wrote {value} to {operand}", "{operand} mit {value} beschrieben"),
    "POST /api/set": ("wrote {value} to {address}", "{address} mit {value} beschrieben"),
    "POST /api/setup": ("set the first password, for {name}", "erstes Passwort gesetzt, für {name}"),
    "POST /api/login": ("logged in as {name}", "angemeldet als {name}"),
    "POST /api/logout": ("logged out", "abgemeldet"),
    "POST /api/users": ("saved user {name} as {role}", "Benutzer {name} als {role} gespeichert"),
    "POST /api/users/drop": ("removed user {name}", "Benutzer {name} entfernt"),
    "POST /api/tokens": ("made the token {label} for {role}", "Token {label} für {role} angelegt"),
    "POST /api/tokens/drop": ("removed the token {name}", "Token {name} entfernt"),
    "pendant key": ("pressed {name} at the pendant", "{name} am Handgerät gedrückt"),
    "wrong password": ("wrong password", "falsches Passwort"),
    "web user add": ("added user {name}", "Benutzer {name} angelegt"),
    "web user password": ("changed the password of {name}", "Passwort von {name} geändert"),
    "web user remove": ("removed user {name}", "Benutzer {name} entfernt"),
}
BY_KIND: dict[str, dict[str, Words]] = {  # words for an order, and the field they depend on
    "POST /api/permit on": {
        "True": ("set the enabling inputs of the simulation", "Freigaben der Simulation gesetzt"),
        "False": ("cleared the enabling inputs of the simulation", "Freigaben der Simulation gelöscht"),
    },
    "POST /api/unforce bit": {"None": ("ended all forces", "alles Steuern beendet")},
    "POST /api/cable do": {
        "unplug": ("pulled the cable of {line}", "Kabel von {line} gezogen"),
        "plug": ("plugged the cable of {line}", "Kabel von {line} gesteckt"),
        "damage": ("damaged characters on {line}", "Zeichen auf {line} gestört"),
        "calm": ("cleaned the line {line}", "Leitung {line} gesäubert"),
        "remove": ("removed one end of {line}", "ein Ende von {line} gezogen"),
        "insert": ("put one end of {line} back", "ein Ende von {line} gesteckt"),
    },
    "POST /api/kept kind": {
        "watch": ("kept the watch list {name}", "Beobachtungsliste {name} gespeichert"),
        "scope": ("kept the layout {name}", "Ansicht {name} gespeichert"),
    },
    "POST /api/kept/drop kind": {
        "watch": ("removed the watch list {name}", "Beobachtungsliste {name} gelöscht"),
        "scope": ("removed the layout {name}", "Ansicht {name} gelöscht"),
    },
}
ENDED: Words = ("ended the force of RC input {bit}", "Steuern von RC-Eingang {bit} beendet")
ORDERED: Words = ("ordered the fault {do} at {emulator}", "Störung {do} an {emulator} ausgelöst")
ROLES = {"viewer": "Betrachter", "operator": "Bediener", "setter": "Einrichter", "admin": "Verwalter"}


def sentences_of(what: str, detail: str, axes: Sequence[str]) -> Words:
    """Both languages; an order without a text is shown as stored."""
    try:
        given = json.loads(detail) if detail else {}
    except ValueError:
        given = {}
    if not isinstance(given, dict):
        given = {}
    words = _words(what, given)
    if words is None:
        return f"{what} {detail}".strip(), f"{what} {detail}".strip()
    shown = {name: _shown(value) for name, value in given.items()}
    if isinstance(given.get("velocity"), (int, float)):
        shown["velocity"] = f"{100.0 * given['velocity']:g}"
    german = {**shown, "role": ROLES.get(shown.get("role", ""), shown.get("role", ""))}
    both = _filled(words[0], shown), _filled(words[1], german)
    if what != "POST /api/command" or given.get("code") not in OF_AXES:
        return both
    tail = _of_axes(given, axes)
    return both[0] + tail, both[1] + tail


def _words(what: str, given: dict[str, object]) -> Words | None:
    if what == "POST /api/command":
        return CODES.get(str(given.get("code")))
    if what == "POST /api/fault":
        return ORDERED
    for key, kinds in BY_KIND.items():
        path, _, field = key.rpartition(" ")
        if path == what:
            return kinds.get(str(given.get(field)), ENDED if what == "POST /api/unforce" else None)
    return ORDERS.get(what)


def _of_axes(given: dict[str, object], axes: Sequence[str]) -> str:
    """: A1 to 20, A2 to 5; only the mask if there are no targets."""
    mask = int(str(given.get("mask", 0)))
    targets = given.get("targets")
    ends = targets if isinstance(targets, list) else []
    named = [(n, axis) for n, axis in enumerate(axes) if mask >> n & 1]
    if not named:
        return ""
    moves = str(given.get("code")).startswith("ptp")
    return ": " + ", ".join(f"{axis} {ends[n]:g}" if moves and n < len(ends) else axis for n, axis in named)


def _shown(value: object) -> str:
    return ", ".join(str(each) for each in value) if isinstance(value, list) else str(value)


def _filled(words: str, given: dict[str, str]) -> str:
    for name, value in given.items():
        words = words.replace("{" + name + "}", value)
    return words
