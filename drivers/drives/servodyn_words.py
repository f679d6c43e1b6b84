"""SERVODYN-GC in words: every state and every fault, German and English, with the numbers an old pendant would show.

Faults of the booster: AX-082; numbers 643..684 and their meaning: robotstar 8.1 (ROBOTstar V, L4684-4744), the closest list of
regulator errors the manuals have.  State sentences answer "why is it not moving?" (AX-269).
"""

from collections.abc import Mapping
from dataclasses import dataclass

from drivers.drives.servodyn import Drive, Phase

PREFIX = ("Fehler Servoregler", "Servoregulator error")  # robotstar 8.1 (L4671-4684)


@dataclass(frozen=True, slots=True)
class Words:
    """One sentence in two languages."""

    german: str
    english: str

    def in_language(self, language: str) -> str:
        """de | en."""
        return self.german if language == "de" else self.english


@dataclass(frozen=True, slots=True)
class FaultRow:
    """A fault code of the booster: number in the old list (0: none fits), meaning, remedy."""

    number: int
    what: Words
    todo: Words


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """State of the drive of one axis."""

    state: Phase
    number: int  # of the old error list, 0: no error or none fits
    code: int  # of the booster
    text: Words
    todo: Words


_NOTHING = Words("", "")
STATES: Mapping[Phase, Words] = {
    Phase.OFF: Words("Antrieb aus, betriebsbereit", "drive off, ready"),
    Phase.POWERING: Words("Leistung wird zugeschaltet", "power is being switched on"),
    Phase.ENABLING: Words("Leistung an, Regler wird freigegeben", "power on, controller is being enabled"),
    Phase.RELEASING: Words("Antrieb geregelt, Bremse wird geloest", "in control, brake is being released"),
    Phase.ENABLED: Words("Antrieb geregelt, folgt dem Sollwert", "in control, follows the set value"),
    Phase.DISABLING: Words("Antrieb bremst und schliesst die Bremse", "drive ramps down and closes the brake"),
    Phase.UNPOWERING: Words("Leistung wird abgeschaltet", "power is being switched off"),
    Phase.FAULT: Words("Antrieb gestoert", "drive has a fault"),
    Phase.LOST: Words("kein Istwerttelegramm vom Antrieb", "no actual value from the drive"),
}
_CAN = Words(
    "CAN-Kabel, Stecker und Abschluss (120 Ohm an beiden Enden) pruefen; dann quittieren",
    "check CAN cable, plugs and termination (120 ohm at both ends); then acknowledge",
)
_LOAD = Words("Last, Bremse und Schwergaengigkeit pruefen, abkuehlen lassen", "check load, brake and sluggish mechanics, let it cool down")
FAULTS: Mapping[int, FaultRow] = {
    1: FaultRow(667, Words("CAN-Ueberwachung: SYNC ausgeblieben", "CAN watchdog: SYNC missing"), _CAN),
    2: FaultRow(667, Words("CAN-Ueberwachung: Lebenszaehler steht", "CAN watchdog: life counter stands still"), _CAN),
    3: FaultRow(
        647,
        Words("Schleppabstand zu gross", "tracking distance too long"),
        Words("Mechanik, Drehmoment, Verstaerkung und Geschwindigkeit pruefen", "check mechanics, torque, gains and speed"),
    ),
    4: FaultRow(
        646,
        Words("Sollwertsprung: geforderte Geschwindigkeit zu hoch", "set value jumped: demanded speed too high"),
        Words("Takt und Massstab (Impulse, Getriebe) pruefen", "check clock and scaling (pulses, gear)"),
    ),
    5: FaultRow(
        0,
        Words("Software-Endschalter des Antriebs erreicht", "software limit of the drive reached"),
        Words("Quittieren und zurueckfahren; Grenzen P204, P205 pruefen", "acknowledge and move back; check limits P204, P205"),
    ),
    6: FaultRow(
        0,
        Words("Hardware-Endschalter erreicht", "hard limit switch reached"),
        Words("Quittieren und zurueckfahren", "acknowledge and move back"),
    ),
    7: FaultRow(
        671,
        Words("Ueberdrehzahl: 120 % der hoechsten Motordrehzahl", "overspeed: 120 % of the maximum motor speed"),
        Words("Verstaerkungen senken, Drehrichtung des Gebers pruefen", "reduce gains, check the encoder's direction"),
    ),
    8: FaultRow(657, Words("I2t-Ueberwachung: Motor im Takt ueberlastet", "I2t monitoring: motor overloaded in the cycle"), _LOAD),
    9: FaultRow(658, Words("Uebertemperatur Motor", "excess temperature motor"), _LOAD),
    10: FaultRow(
        0,
        Words("Stopprampe endete nicht rechtzeitig", "stop ramp did not end in time"),
        Words("Stoprampe P608 und Schwungmasse pruefen", "check stop ramp P608 and inertia"),
    ),
    11: FaultRow(
        653,
        Words("Unterspannung im Zwischenkreis", "undervoltage of the DC link"),
        Words("Netz, Sicherungen und Leistungsschuetze pruefen", "check mains, fuses and power contactors"),
    ),
    12: FaultRow(
        673,
        Words("Kabelbruch in der Motorphase", "cable break in the motor phase"),
        Words("Motorkabel und Schuetz pruefen", "check motor cable and contactor"),
    ),
    13: FaultRow(656, Words("Uebertemperatur Leistungselektronik", "excess temperature power electronics"), _LOAD),
    14: FaultRow(
        662,
        Words("Resolversignale fehlerhaft", "resolver signals faulty"),
        Words("Resolver und Verkabelung pruefen, danach neu referenzieren", "check resolver and cabling, then reference again"),
    ),
    15: FaultRow(
        0,
        Words("Bremse oeffnet nicht", "brake does not open"),
        Words("Bremsenversorgung und Bremse pruefen", "check the brake and its supply"),
    ),
}
_UNKNOWN = FaultRow(
    0,
    Words("Antrieb meldet einen Fehler, den diese Liste nicht kennt", "the drive reports a fault that is not in this list"),
    Words("Anzeige am Antrieb ablesen", "read the display of the drive"),
)
_LOST = Words(
    "CAN-Kabel und Versorgung des Antriebs pruefen; nach der Rueckkehr neu referenzieren",
    "check CAN cable and supply of the drive; reference again when it is back",
)


def fault(code: int) -> FaultRow:
    """Meaning of a fault code; returns a row for unknown ones, too."""
    return FAULTS.get(code, _UNKNOWN)


def sentence(code: int, language: str = "en") -> str:
    """A fault code in one line: "code 1 = 667 CAN watchdog: SYNC missing"."""
    row = fault(code)
    number = f"{row.number} " if row.number else ""
    return f"code {code} = {number}{row.what.in_language(language)}"


def diagnose(drive: Drive) -> Diagnosis:
    """State, and during a fault its number, sentence and remedy."""
    phase, code = drive.phase, drive.fault_code
    if phase is Phase.FAULT or code:
        row = fault(code)
        text = Words(f"{_prefixed(0, row.number)}{row.what.german}", f"{_prefixed(1, row.number)}{row.what.english}")
        return Diagnosis(phase, row.number, code, text, row.todo)
    if phase is Phase.LOST:
        return Diagnosis(phase, 0, 0, STATES[phase], _LOST)
    return Diagnosis(phase, 0, 0, STATES[phase], _NOTHING)


def _prefixed(language: int, number: int) -> str:
    return f"{PREFIX[language]} {number}: " if number else f"{PREFIX[language]}: "
