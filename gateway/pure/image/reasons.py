"""Why a command was refused or a move ended: the numbers a PLC reads in word 1 of its status block (AX-011, AX-140).

The texts are what log, page and `axisgate var` show; {0} is filled with the particulars.
"""

from dataclasses import dataclass
from enum import IntEnum


class CommandState(IntEnum):
    """Bits 0-7 of status word 0 (AX-011)."""

    NONE = 0
    ACCEPTED = 1
    RUNNING = 2
    DONE = 3
    REFUSED = 4
    ABORTED = 5


class Reason(IntEnum):
    """Word 1 of the status block."""

    NONE = 0
    NOT_OWNER = 1
    DRIVES_OFF = 2
    NOT_REFERENCED = 3
    TARGET_LIMIT = 4
    FORMAT_SUSPICION = 5
    FEED_NOT_ALLOWED = 6
    BUSY = 7
    EMERGENCY_STOP = 8
    UNKNOWN_CODE = 9
    MASK = 10
    RATE = 11
    NOT_AT_REST = 12
    NOTHING_TO_RESUME = 13
    CONTROL_NOT_ALLOWED = 14
    TRAVEL_NOT_ALLOWED = 15
    DRIVE_FAULT = 16
    DRIVE_LOST = 17
    FOLLOWING_ERROR = 18
    STOPPED_BY_SOURCE = 19
    RESYNCHRONISED = 20
    LINK_LOST = 21
    SERVICES_LOST = 22
    CYCLE_RESTARTED = 23
    REFERENCE_FAILED = 24
    TIME_OUT = 25
    INPUT_LOST = 26
    OVERRUN = 27
    ABANDONED = 28
    OVERRIDE_ZERO = 29
    NOT_READY = 30
    SET_VALUE = 31
    DRIVE_NOT_STARTED = 32
    PLANNER_LOST = 33
    PROGRAM_FAULT = 34
    PROGRAM_UNKNOWN = 35
    BELT_FAULT = 36
    OUTPUT_IN_USE = 37
    OUTPUT_STOPPED = 38
    ALTER_FAULT = 39
    SERVO_ERROR = 40
    DRIVE_ON_NOT_AVAILABLE = 41
    DRIVE_ON_NOT_ALLOWED = 42
    INTERPOLATOR_STOP = 43
    MACHINE_LATE = 44
    COUPLER_FAULT = 45
    APPLICATION = 46
    PATH_LATE = 47
    PATH_JOIN = 48


@dataclass(frozen=True, slots=True)
class Refusal(Exception):
    """A command that is not carried out: the number for the PLC and the particulars for a person."""

    reason: Reason
    detail: str = ""

    def __str__(self) -> str:
        return text(self.reason, "en", self.detail)


# fmt: off
_TEXTS: dict[Reason, tuple[str, str]] = {
    Reason.NONE: ("", ""),
    Reason.NOT_OWNER: ("this command source does not have control: {0}", "diese Befehlsquelle hat die Steuerung nicht: {0}"),
    Reason.DRIVES_OFF: ("drives are off: {0}", "Antriebe sind aus: {0}"),
    Reason.NOT_REFERENCED: ("axis is not referenced: {0}", "Achse ist nicht referenziert: {0}"),
    Reason.TARGET_LIMIT: ("target outside the limits: {0}", "Ziel ausserhalb der Grenzen: {0}"),
    Reason.FORMAT_SUSPICION: ("number format: {0}", "Zahlenformat: {0}"),
    Reason.FEED_NOT_ALLOWED: (
        "feed is not allowed (RC input 26 feed allow, or that of the kinematic): {0}",
        "Vorschub nicht freigegeben (RC-Eingang 26 oder der der Kinematik): {0}",
    ),
    Reason.BUSY: ("a move is running: {0}", "eine Bewegung laeuft: {0}"),
    Reason.EMERGENCY_STOP: (
        "emergency stop is latched: close the chain (RC input 24), then fault reset",
        "Not-Halt gespeichert: Kette schliessen (RC-Eingang 24), dann quittieren",
    ),
    Reason.UNKNOWN_CODE: ("command code {0} is unknown; 1..13 are known", "Kommandocode {0} unbekannt; 1..13 sind bekannt"),
    Reason.MASK: ("axis mask {0}", "Achsmaske {0}"),
    Reason.RATE: (
        "velocity, acceleration or override out of range: {0}",
        "Geschwindigkeit, Beschleunigung oder Override ausserhalb: {0}",
    ),
    Reason.NOT_AT_REST: ("axes are not at rest", "Achsen stehen nicht"),
    Reason.NOTHING_TO_RESUME: ("there is no stopped move to resume or abandon", "keine angehaltene Bewegung vorhanden"),
    Reason.CONTROL_NOT_ALLOWED: ("control is not allowed (RC input 25 control allow)", "Steuerung nicht freigegeben (RC-Eingang 25)"),
    Reason.TRAVEL_NOT_ALLOWED: ("travel is not allowed (RC input 28 travel allow)", "Fahren nicht freigegeben (RC-Eingang 28)"),
    Reason.DRIVE_FAULT: ("drive fault: {0}", "Antriebsfehler: {0}"),
    Reason.DRIVE_LOST: ("no telegram from a drive: {0}", "kein Telegramm vom Antrieb: {0}"),
    Reason.FOLLOWING_ERROR: ("following error: {0}", "Schleppfehler: {0}"),
    Reason.STOPPED_BY_SOURCE: ("stopped on the path by command source {0}", "auf der Bahn angehalten durch Befehlsquelle {0}"),
    Reason.RESYNCHRONISED: (
        "first telegram after a start or a lost link: not carried out, send it again with the toggle changed",
        "erstes Telegramm nach Start oder Verbindungsverlust: nicht ausgefuehrt, mit gewechseltem Toggle neu senden",
    ),
    Reason.LINK_LOST: ("no telegrams from the active command source: {0}", "keine Telegramme von der aktiven Befehlsquelle: {0}"),
    Reason.SERVICES_LOST: ("the services process failed; stopped on the path", "Dienste-Prozess ausgefallen; auf der Bahn angehalten"),
    Reason.PLANNER_LOST: (
        "the planner process failed; the axes stopped on the path",
        "Planer-Prozess ausgefallen; die Achsen haben auf der Bahn angehalten",
    ),
    Reason.PROGRAM_FAULT: ("a block of the program cannot be run: {0}", "ein Satz des Programms ist nicht fahrbar: {0}"),
    Reason.PROGRAM_UNKNOWN: ("there is no such program: {0}", "dieses Programm gibt es nicht: {0}"),
    Reason.BELT_FAULT: ("belt-synchronous section aborted: {0}", "bandsynchroner Abschnitt abgebrochen: {0}"),
    Reason.ALTER_FAULT: ("alter section aborted: {0}", "Alter-Abschnitt abgebrochen: {0}"),
    Reason.SERVO_ERROR: (
        "servo error: two axes of one set-point output moved: {0}",
        "Servofehler: zwei Achsen eines Sollwertausgangs bewegten sich: {0}",
    ),
    Reason.OUTPUT_IN_USE: ("IOL/PPO:Fkt. still in use: {0}", "IOL/PPO:Funktion noch in Gebrauch: {0}"),
    Reason.OUTPUT_STOPPED: ("PPO/IOL : IPO - STOP: {0}", "PPO/IOL : IPO - STOP: {0}"),
    Reason.DRIVE_ON_NOT_AVAILABLE: ("DRIVE ON not avail.: {0}", "ANTRIEB EIN fehlt: {0}"),
    Reason.DRIVE_ON_NOT_ALLOWED: ("DRIVE ON not allowed: {0}", "ANTRIEB EIN nicht erlaubt: {0}"),
    Reason.COUPLER_FAULT: ("I/O coupler: {0}", "E/A-Koppler: {0}"),
    Reason.APPLICATION: ("application: {0}", "Applikation: {0}"),
    Reason.INTERPOLATOR_STOP: ("warning: {0}", "Warnung: {0}"),
    Reason.MACHINE_LATE: (
        "this machine was late: simulated drives stopped: {0}",
        "dieser Rechner war zu spaet: simulierte Antriebe hielten an: {0}",
    ),
    Reason.CYCLE_RESTARTED: ("the cycle process was restarted; drives are off", "Zyklus-Prozess neu gestartet; Antriebe sind aus"),
    Reason.REFERENCE_FAILED: ("referencing failed: {0}", "Referenzieren fehlgeschlagen: {0}"),
    Reason.TIME_OUT: ("not reached in time: {0}", "nicht rechtzeitig erreicht: {0}"),
    Reason.INPUT_LOST: ("an enabling input is lost: {0}", "ein Freigabeeingang ist ausgefallen: {0}"),
    Reason.OVERRUN: (
        "the cycle skipped too many SYNCs in a row; stopped on the path",
        "zu viele SYNC in Folge ausgelassen; auf der Bahn angehalten",
    ),
    Reason.ABANDONED: ("the rest of the move was abandoned", "Restweg verworfen"),
    Reason.OVERRIDE_ZERO: ("override is 0 %: nothing would move", "Override ist 0 %: nichts wuerde sich bewegen"),
    Reason.SET_VALUE: ("a set value jumped or left the range of the telegram", "ein Sollwert sprang oder verliess den Telegrammbereich"),
    Reason.DRIVE_NOT_STARTED: ("drive is not started up: {0}", "Antrieb ist nicht hochgelaufen: {0}"),
    Reason.PATH_LATE: (
        "the planner was too slow: the new path arrived after the axes had passed its start",
        "der Planer war zu langsam: die neue Bahn kam, als die Achsen an ihrem Anfang schon vorbei waren",
    ),
    Reason.PATH_JOIN: (
        "a piece of the path does not continue the one before, or is damaged",
        "ein Bahnstueck schliesst nicht an das vorige an oder ist beschaedigt",
    ),
    Reason.NOT_READY: ("the cell is not ready: {0}", "Zelle nicht bereit: {0}"),
}
# fmt: on


def text(reason: Reason, language: str = "en", detail: str = "") -> str:
    """The sentence for a reason; language "de" or "en"."""
    return _TEXTS[reason][1 if language == "de" else 0].format(detail).rstrip(": ")
