"""Meaning of a drive's error code in the operator's language.  Source: IEC 61800-7-201, object 603Fh; CiA 301, emergency error codes.

The English texts are `protocols.canopen.emcy.MEANINGS`; this module adds the German texts and what to check first.
"""

from collections.abc import Mapping

from protocols.canopen.emcy import MEANINGS

GERMAN: Mapping[int, str] = {
    0x0000: "kein Fehler oder Fehler gegangen",
    0x1000: "allgemeiner Fehler",
    0x2000: "Strom",
    0x2200: "Strom im Geraet",
    0x2310: "Dauerueberstrom",
    0x2311: "Dauerueberstrom 1",
    0x2320: "Kurzschluss oder Erdschluss",
    0x2330: "Erdschluss",
    0x2340: "Kurzschluss",
    0x2350: "Ueberlast (I2t)",
    0x2351: "Warnung Ueberlast (I2t)",
    0x3000: "Spannung",
    0x3110: "Netzueberspannung",
    0x3120: "Netzunterspannung",
    0x3130: "Phasenausfall",
    0x3210: "Ueberspannung im Zwischenkreis",
    0x3220: "Unterspannung im Zwischenkreis",
    0x4000: "Temperatur",
    0x4110: "Umgebung zu warm",
    0x4210: "Geraet zu warm",
    0x4310: "Motor zu warm",
    0x5000: "Geraetehardware",
    0x5200: "Steuerteil",
    0x5400: "Leistungsteil",
    0x5440: "Schuetze",
    0x5530: "nichtfluechtiger Speicher",
    0x6000: "Geraetesoftware",
    0x6100: "Firmware",
    0x6320: "Parameterfehler",
    0x7110: "Bremschopper",
    0x7120: "Motor",
    0x7121: "Motor blockiert",
    0x7122: "Motor- oder Kommutierungsfehler",
    0x7300: "Geber",
    0x7303: "Resolver 1 gestoert",
    0x7305: "Inkrementalgeber 1 gestoert",
    0x7310: "Drehzahl",
    0x7320: "Lage",
    0x7380: "Lagegeber (herstellerspezifisch)",
    0x7500: "Kommunikation",
    0x8000: "Ueberwachung",
    0x8110: "CAN-Ueberlauf, Telegramme verloren",
    0x8120: "CAN ist error passive",
    0x8130: "Heartbeat oder Life Guarding ausgeblieben",
    0x8140: "nach Bus-off wieder da",
    0x8150: "CAN-Kennung doppelt",
    0x8200: "Protokollfehler",
    0x8210: "PDO zu kurz",
    0x8220: "PDO zu lang",
    0x8240: "SYNC mit falscher Laenge",
    0x8250: "RPDO ausgeblieben",
    0x8311: "Drehmoment zu hoch",
    0x8400: "Drehzahlregler",
    0x8500: "Lageregler",
    0x8611: "Schleppfehler",
    0x8612: "Endlage",
    0x8613: "Referenzfahrt gescheitert",
    0x8700: "Synchronisation",
    0x9000: "externer Fehler",
    0xF001: "Bremsen",
    0xFF00: "herstellerspezifisch",
}
LOOK: Mapping[int, tuple[str, str]] = {  # what to check: English, German
    0x2310: ("load, brake, acceleration", "Last, Bremse, Beschleunigung"),
    0x2350: ("load, brake, acceleration", "Last, Bremse, Beschleunigung"),
    0x3130: ("mains fuses and contactor", "Netzsicherungen und Schuetz"),
    0x3210: ("braking resistor, mains", "Bremswiderstand, Netz"),
    0x3220: ("mains, contactor, emergency stop", "Netz, Schuetz, Not-Halt"),
    0x7121: ("mechanics, brake", "Mechanik, Bremse"),
    0x7300: ("encoder cable and plug", "Geberkabel und Stecker"),
    0x8130: ("the gateway or its cable was away", "Gateway oder Kabel war weg"),
    0x8140: ("bus termination, cable, bit rate", "Abschluss, Kabel, Bitrate"),
    0x8611: ("mechanics, brake, limits.accel, following_error", "Mechanik, Bremse, limits.accel, following_error"),
    0x8613: ("home switch and its wiring", "Referenzschalter und Verdrahtung"),
    0x8700: ("cycle_ms, bus load, SYNC jitter", "cycle_ms, Buslast, SYNC-Jitter"),
}


def sentence(code: int, language: str = "en") -> str:
    """One line: the fault, its number, what to check; language "de" or "en"."""
    table = GERMAN if language == "de" else MEANINGS
    masks = (0xFFFF, 0xFFF0, 0xFF00, 0xF000)
    found = next((table[code & mask] for mask in masks if code & mask in table and (code & mask or not code)), None)
    words = found or ("unbekannter Fehler" if language == "de" else "unknown error")
    look = next((LOOK[code & mask] for mask in masks[:3] if code & mask in LOOK), None)
    if code == 0:
        return words
    advice = f"; {('pruefen: ' if language == 'de' else 'look at: ')}{look[1 if language == 'de' else 0]}" if look else ""
    return f"{words} ({code:04X}h){advice}"
