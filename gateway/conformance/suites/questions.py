"""The PICS of each suite: statements of the maker about the device."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Question:
    """One item.  kind: bool, text, whole, table; `asked`: by new-pics, with this text."""

    key: str
    kind: str
    text: str
    text_de: str


def _keys(link: str, more: str) -> frozenset[str]:
    return frozenset((*(f"link.{key}" for key in link.split()), *more.split()))


LINE_KEYS = _keys("profile priority times layer block_check missing_db db words reaction_ms", "touch.db known.DB stimulus")
MODBUS_KEYS = _keys("times unit missing_unit answer_ms", "touch.holding touch.coils known.input known.holding known.coil known.discrete")
CANOPEN_KEYS = _keys("node eds answer_ms boot_ms cycle_ms", "touch.objects touch.store touch.node")
DRIVE_KEYS = CANOPEN_KEYS | _keys("speed way", "touch.motion")
BOOSTER_KEYS = _keys("module layout cycle_ms boot_ms answer_ms way turn stop_ms", "touch.motion touch.store")

LINE = (
    Question("profile", "text", "link profile of the station (axisgate line probe -h lists them)", "Profil der Station"),
    Question("priority", "text", "priority of the station: high or low", "Priorität der Station: high oder low"),
    Question("block_check", "bool", "with block check (3964R); false: 3964", "mit Blockprüfung (3964R); false: 3964"),
    Question("most_received", "whole", "longest block it takes, characters before doubling", "längster Block, den sie nimmt"),
    Question("rk512", "bool", "speaks RK512", "spricht RK512"),
    Question("passive", "bool", "serves SEND and FETCH", "bedient SEND und FETCH"),
    Question("active", "bool", "sends RK512 commands of its own", "sendet eigene RK512-Aufträge"),
    Question(
        "flags",
        "bool",
        "keeps a coordination flag set: a second job gets 32h",
        "hält den Koordinierungsmerker: ein zweiter Auftrag erhält 32h",
    ),
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
    Question("most_registers", "whole", "registers in one request, where it limits them", "Register je Anfrage, wo es sie begrenzt"),
    Question("most_bits", "whole", "coils in one request, where it limits them", "Spulen je Anfrage, wo es sie begrenzt"),
    Question("mapped", "bool", "its tables overlap on purpose", "seine Tabellen überlappen sich absichtlich"),
    Question("broadcast", "bool", "serves broadcasts (RTU)", "bedient Rundsprüche (RTU)"),
)
CANOPEN = (
    Question("node", "whole", "node number, 1 to 127", "Knotennummer, 1 bis 127"),
    Question("reset", "bool", "may be reset by NMT", "darf über NMT zurückgesetzt werden"),
    Question("segmented", "bool", "serves segmented SDO transfers", "bedient segmentierte SDO-Transfers"),
    Question("block", "bool", "serves SDO block transfers", "bedient SDO-Block-Transfers"),
    Question("heartbeat", "bool", "produces a heartbeat (1017h)", "erzeugt einen Heartbeat (1017h)"),
    Question("guarding", "bool", "answers node guarding (100Ch, 100Dh)", "beantwortet Node Guarding (100Ch, 100Dh)"),
    Question("consumer", "bool", "watches the heartbeat of others (1016h)", "überwacht den Heartbeat anderer (1016h)"),
    Question("emcy", "bool", "sends emergency messages (1014h)", "sendet Emergency-Nachrichten (1014h)"),
    Question("history", "bool", "keeps its errors (1003h)", "hält seine Fehler (1003h)"),
    Question("error_behaviour", "bool", "error behaviour can be chosen (1029h)", "Fehlerverhalten ist wählbar (1029h)"),
    Question("sync", "bool", "acts on SYNC (1005h)", "reagiert auf SYNC (1005h)"),
    Question("sync_counter", "bool", "SYNC with counter (1019h)", "SYNC mit Zähler (1019h)"),
    Question("tpdo", "bool", "sends TPDO 1 (1800h)", "sendet TPDO 1 (1800h)"),
    Question("rpdo", "bool", "takes RPDO 1 (1400h)", "nimmt RPDO 1 (1400h)"),
    Question("tpdo_setup", "bool", "the parameters of TPDO 1 can be changed (1800h)", "die Parameter von TPDO 1 sind änderbar (1800h)"),
    Question("rpdo_setup", "bool", "the parameters of RPDO 1 can be changed (1400h)", "die Parameter von RPDO 1 sind änderbar (1400h)"),
    Question("mapping", "bool", "the mapping of its PDOs can be changed", "das Mapping seiner PDOs ist änderbar"),
    Question("store", "bool", "stores its parameters (1010h)", "speichert seine Parameter (1010h)"),
    Question("restore", "bool", "restores its defaults (1011h)", "stellt seine Vorgaben wieder her (1011h)"),
    Question("lss", "bool", "layer setting services (CiA 305)", "Layer Setting Services (CiA 305)"),
)
DRIVE = (
    *CANOPEN,
    Question("pp", "bool", "profile position", "Betriebsart Profile Position"),
    Question("pv", "bool", "profile velocity", "Betriebsart Profile Velocity"),
    Question("hm", "bool", "homing", "Betriebsart Homing"),
    Question("homing_moves", "bool", "homing to the index (method 34)", "Referenzieren auf den Index (Verfahren 34)"),
    Question("csp", "bool", "cyclic synchronous position", "Betriebsart Cyclic Synchronous Position"),
    Question("modes", "bool", "names its modes of operation (6502h)", "nennt seine Betriebsarten (6502h)"),
    Question("velocity", "bool", "shows its speed (606Ch)", "zeigt seine Geschwindigkeit (606Ch)"),
    Question("top_speed", "bool", "limits its speed (607Fh)", "begrenzt seine Geschwindigkeit (607Fh)"),
    Question("quick_option", "bool", "quick stop option code (605Ah)", "Quick-Stop-Option (605Ah)"),
    Question("shutdown_option", "bool", "shutdown option code (605Bh)", "Shutdown-Option (605Bh)"),
    Question("disable_option", "bool", "disable operation option code (605Ch)", "Disable-Operation-Option (605Ch)"),
    Question("halt_option", "bool", "halt option code (605Dh)", "Halt-Option (605Dh)"),
    Question("fault_option", "bool", "fault reaction option code (605Eh)", "Fehlerreaktions-Option (605Eh)"),
    Question("abort_option", "bool", "abort connection option code (6007h)", "Option bei Verbindungsabbruch (6007h)"),
    Question("following", "bool", "following error window (6065h)", "Schleppfehlerfenster (6065h)"),
    Question("limits", "bool", "software position limits (607Dh)", "Software-Endlagen (607Dh)"),
    Question("window", "bool", "position window (6067h)", "Positionsfenster (6067h)"),
    Question("period", "bool", "interpolation time period (60C2h)", "Interpolationszeit (60C2h)"),
)
BOOSTER = (
    Question("module", "whole", "module number, 1 to 6", "Modulnummer, 1 bis 6"),
    Question("parameters", "bool", "takes drive parameters over the bus (AX-266)", "nimmt Antriebsparameter über den Bus (AX-266)"),
    Question("life", "bool", "watches the life counter", "überwacht den Lebenszähler"),
)
