"""Texts of the functions in German and English: faults of files, panel and log."""

from dataclasses import dataclass

# fmt: off
_TEXTS: dict[str, tuple[str, str]] = {
    "no_equals": ("no '=' in this line", "kein '=' in dieser Zeile"),
    "two_decimal": ("{0!r}: two decimal digits 01 to 99 expected", "{0!r}: zwei Dezimalziffern 01 bis 99 verlangt"),
    "two_hex_upper": ("{0!r}: two hex digits 00 to FF expected, letters in upper case",
                      "{0!r}: zwei Hexziffern 00 bis FF verlangt, Buchstaben gross"),
    "two_hex": ("{0!r}: two hex digits 00 to FF expected", "{0!r}: zwei Hexziffern 00 bis FF verlangt"),
    "one_hex": ("{0!r}: one hex digit 0 to F expected", "{0!r}: eine Hexziffer 0 bis F verlangt"),
    "quotes": ("text between two single quotes expected", "Text zwischen zwei Hochkommas verlangt"),
    "control": ("control character in the text", "Steuerzeichen im Text"),
    "long": ("{0} characters; at most 80", "{0} Zeichen; hoechstens 80"),
    "behind": ("{0!r} after the value; a comment begins with ;", "{0!r} hinter dem Wert; ein Kommentar beginnt mit ;"),
    "channel": ("channel {0!r}; only PHG", "Kanal {0!r}; nur PHG"),
    "comma": ("no comma after the channel", "kein Komma hinter dem Kanal"),
    "name": ("{0!r}: program name of up to 8 letters, digits and _ expected",
             "{0!r}: Programmname aus bis zu 8 Buchstaben, Ziffern und _ verlangt"),
    "mode": ("{0!r}: mode like 7.3.2 without blanks expected", "{0!r}: Mode wie 7.3.2 ohne Leerzeichen verlangt"),
    "twice": ("{0} is given twice; the first one counts", "{0} steht zweimal da; das erste gilt"),
    "no_file": ("file not found", "Datei nicht gefunden"),
    "large": ("file has more than {0} bytes", "Datei hat mehr als {0} Bytes"),
    "unreadable": ("file cannot be read: {0}", "Datei nicht lesbar: {0}"),
    # lines of 20 characters on the panel
    "phg_code_error": ("Error in PHGCODE.DAT", "Fehler PHGKODE.DAT"),
    "phg_msd_missing": ("MSD.DAT not found", "MZA.DAT fehlt"),
    "phg_msd_title": ("Machine statuses", "Maschinenzustaende"),
    "phg_msd": ("MSD", "MZA"),
    "phg_no_status": ("no status active", "kein Zustand aktiv"),
    "phg_basic": ("Basic level", "Grundebene"),
    "phg_automatic": ("Automatic", "Automatik"),
    "phg_manual": ("Manual", "Hand"),
    "phg_no_error": ("no error, no warning", "kein Fehler"),
    "phg_no_board": ("no board with them", "keine Karte damit"),
    "phg_no_process": ("no process", "kein Prozess"),
    "phg_no_program": ("no program", "kein Programm"),
    "phg_no_points": ("no point file", "keine Punktdatei"),
    "phg_sure": ("sure? (yes): ENTER", "sicher? (ja): ENTER"),
    "phg_enter_password": ("Enter password!", "Passwort eingeben!"),
    "phg_password": ("Password", "Passwort"),
    "phg_no_parameter": ("no parameter", "kein Parameter"),
    "phg_not_manual": ("kin. in automatic", "Kin. in Automatik"),
    "phg_taught": ("taught", "gelernt"),
    "phg_no_value": ("no number", "keine Zahl"),
    "phg_overwrite": ("pnt. overwr.:ENTER", "Pkt ueberschr.:ENTER"),
    "phg_not_here": ("no function here", "hier ohne Funktion"),
    "phg_done": ("done", "ausgefuehrt"),
    "phg_execute": ("execute with: ENTER", "ausfuehren mit ENTER"),
    "phg_with": ("WITH movement", "MIT Bewegung"),
    "phg_without": ("WITHOUT movement", "OHNE Bewegung"),
    "phg_held": ("held", "steht"),
    "phg_started": ("started", "gestartet"),
    "phg_stopped": ("stopped", "beendet"),
    "phg_factor_range": ("0 to 1.0", "0 bis 1.0"),
    # refusals of the coded functions, for log and page
    "both_strobes": ("selection and abort strobe together", "Anwahl- und Abbruchstrobe zugleich"),
    "parity": ("wrong parity of code {0}", "falsche Paritaet des Codes {0}"),
    "no_code": ("{0} has no code {1}", "{0} hat keinen Code {1}"),
    "no_process": ("no process {0}", "kein Prozess {0}"),
    "not_started": ("{0} not started: error {1}", "{0} nicht gestartet: Fehler {1}"),
    "not_good": ("the code comes from a lost command source", "der Code kommt von einer verlorenen Befehlsquelle"),
    "channel_busy": ("the panel is occupied", "das PHG ist belegt"),
    "channel_off": ("the panel is not ready", "das PHG ist nicht bereit"),
    # states and kinds of processes
    "READY": ("ready", "bereit"), "RUNNING": ("active", "aktiv"), "WAITING": ("waits", "wartet"), "FAULTY": ("error", "Fehler"),
    "STUCK": ("blocked", "block."),
    "held_by": (" has: {0}", " hat: {0}"),
    "NORMAL": ("normal", "normal"), "PERMANENT": ("perm.", "perm."), "SUB": ("sub", "sub"), "TEST": ("test", "Test"),
    # groups of error codes (L2953-3017)
    "group_0": ("process runtime errors", "Prozesslaufzeitfehler"),
    "group_1": ("CAN errors", "CAN-Fehler"),
    "group_2": ("P2 cycle, measuring system, travel limit, emergency stop", "P2-Takt, Messsystem, Endlage, NOT-AUS"),
    "group_3": ("servo, INPOS, interpolator stop, drive on", "Servo, INPOS, Interpolator-Stop, Antrieb ein"),
    "group_4": ("PIC/PLC and other errors", "PIC/SPS und andere Fehler"),
    "group_5": ("warnings", "Warnungen"),
    "group_unused": ("not used", "nicht belegt"),
    "group_13": ("P2 runtime errors", "P2-Laufzeitfehler"),
    "group_14": ("system errors", "Systemfehler"),
    "group_15": ("system errors, reserved", "Systemfehler, reserviert"),
}
# fmt: on


@dataclass(frozen=True, slots=True)
class Text:
    """A text of the table with its particulars."""

    key: str
    values: tuple[str, ...] = ()

    def text(self, language: str) -> str:
        """In German ("de") or English."""
        return _TEXTS[self.key][language == "de"].format(*self.values)


def say(key: str, language: str, *values: str) -> str:
    """The text `key` in that language."""
    return Text(key, values).text(language)


def keys() -> tuple[str, ...]:
    """All keys of the table."""
    return tuple(_TEXTS)
