"""The PICS of each suite: what a maker states of the device."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Question:
    """One item.  kind: bool, text, whole, table; `asked`: by new-pics, with this text."""

    key: str
    kind: str
    text: str
    text_de: str


LINE = (
    Question("profile", "text", "link profile of the station (axisgate line probe -h lists them)", "Profil der Station"),
    Question("priority", "text", "priority of the station: high or low", "Priorität der Station: high oder low"),
    Question("block_check", "bool", "with block check (3964R); false: 3964", "mit Blockprüfung (3964R); false: 3964"),
    Question("most_received", "whole", "longest block it takes, characters before doubling", "längster Block, den sie nimmt"),
    Question("rk512", "bool", "speaks RK512", "spricht RK512"),
    Question("passive", "bool", "serves SEND and FETCH", "bedient SEND und FETCH"),
    Question("active", "bool", "sends RK512 commands of its own", "sendet eigene RK512-Aufträge"),
    Question("words", "whole", "words of the data block that is read", "Wörter des gelesenen Datenbausteins"),
    Question("errors", "table", "own error numbers: missing_block, wrong_type, ...", "eigene Fehlernummern"),
    *(Question(f"type_{kind}", "bool", f"serves FETCH of type {kind}", f"bedient FETCH vom Typ {kind}") for kind in "EAMTZX"),
)
MODBUS = (
    Question("coils", "bool", "has coils", "hat Spulen (Coils)"),
    Question("discrete_inputs", "bool", "has discrete inputs", "hat diskrete Eingänge"),
    Question("holding_registers", "bool", "has holding registers", "hat Halteregister"),
    Question("input_registers", "bool", "has input registers", "hat Eingangsregister"),
    *(
        Question(f"fc{code}", "bool", f"offers function {code}", f"bietet Funktion {code}")
        for code in (5, 6, 7, 8, 11, 12, 15, 16, 17, 20, 21, 22, 23, 24, 43)
    ),
    Question("mapped", "bool", "its tables overlap on purpose", "seine Tabellen überlappen sich absichtlich"),
    Question("broadcast", "bool", "serves broadcasts (RTU)", "bedient Rundsprüche (RTU)"),
)
