"""Errors as the page tells them: number, words in both languages, and what to do about it (AX-140)."""

from gateway.pure.reasons import Reason, text

DO: dict[Reason, tuple[str, str]] = {
    Reason.NOT_OWNER: (
        "Give control back at the other door, or ask for it at rest.",
        "Steuerung an der anderen Tuer abgeben oder im Stillstand anfordern.",
    ),
    Reason.DRIVES_OFF: ("Switch the drives on.", "Antriebe einschalten."),
    Reason.NOT_REFERENCED: ("Reference the axis.", "Achse referenzieren."),
    Reason.TARGET_LIMIT: (
        "Check target and unit, or the limits in the cell file.",
        "Ziel und Einheit pruefen oder die Grenzen in der Zellendatei.",
    ),
    Reason.FORMAT_SUSPICION: (
        "Compare the type in the cell (KG, REAL, KF) with what the PLC sends.",
        "Typ in der Zelle (KG, REAL, KF) mit dem der SPS vergleichen.",
    ),
    Reason.FEED_NOT_ALLOWED: (
        "Set feed allow (RC input 26), or see who writes its byte.",
        "Vorschubfreigabe (RC-Eingang 26) setzen; wer schreibt das Byte?",
    ),
    Reason.BUSY: ("Wait, or stop and abandon the rest.", "Warten oder anhalten und den Rest verwerfen."),
    Reason.EMERGENCY_STOP: (
        "Find out why the chain opened, close it, then reset.",
        "Ursache der offenen Kette klaeren, schliessen, dann quittieren.",
    ),
    Reason.CONTROL_NOT_ALLOWED: ("Set control allow (RC input 25).", "Steuerungsfreigabe (RC-Eingang 25) setzen."),
    Reason.TRAVEL_NOT_ALLOWED: ("Set travel allow (RC input 28).", "Fahrfreigabe (RC-Eingang 28) setzen."),
    Reason.DRIVE_FAULT: (
        "Read the drive's fault, remove its cause, then reset.",
        "Stoerung am Antrieb lesen, Ursache beheben, dann quittieren.",
    ),
    Reason.DRIVE_LOST: (
        "Check supply, plug and address of the drive; the bus page shows who is silent.",
        "Versorgung, Stecker und Adresse pruefen; die Busseite zeigt, wer schweigt.",
    ),
    Reason.FOLLOWING_ERROR: (
        "Look for jammed mechanics, brake, load; then reset.",
        "Schwergaengige Mechanik, Bremse, Last suchen; dann quittieren.",
    ),
    Reason.STOPPED_BY_DOOR: ("Resume, or abandon the rest of the move.", "Fortsetzen oder den Restweg verwerfen."),
    Reason.RESYNCHRONISED: ("Send the command again with the toggle changed.", "Kommando mit gewechseltem Toggle neu senden."),
    Reason.LINK_LOST: (
        "Look at the plug and the partner of that line; it returns by itself, the move by a fresh command.",
        "Stecker und Partner der Leitung ansehen; sie kommt von selbst, die Bewegung durch neues Kommando.",
    ),
    Reason.SERVICES_LOST: (
        "They return by themselves; resume, or abandon the rest.",
        "Sie kommen von selbst; fortsetzen oder Rest verwerfen.",
    ),
    Reason.CYCLE_RESTARTED: ("Read the events, switch the drives on again.", "Ereignisse lesen, Antriebe wieder einschalten."),
    Reason.REFERENCE_FAILED: ("Check the reference switch and its side.", "Referenzschalter und seine Seite pruefen."),
    Reason.TIME_OUT: ("See which axis did not follow; then reset.", "Nachsehen, welche Achse nicht folgte; dann quittieren."),
    Reason.INPUT_LOST: (
        "The door that writes this input is silent: look at its line.",
        "Die Tuer, die diesen Eingang schreibt, ist stumm: Leitung ansehen.",
    ),
    Reason.OVERRUN: (
        "The computer was too slow: other load, priority; axisgate doctor measures it.",
        "Rechner zu langsam: andere Last, Prioritaet; axisgate doctor misst es.",
    ),
    Reason.OVERRIDE_ZERO: ("Raise the override.", "Override erhoehen."),
    Reason.DRIVE_NOT_STARTED: (
        "The events say at which object the start-up stopped.",
        "Die Ereignisse sagen, bei welchem Objekt der Hochlauf stehen blieb.",
    ),
    Reason.PLANNER_LOST: ("It returns by itself; start the program again.", "Er kommt von selbst; Programm neu starten."),
    Reason.PROGRAM_FAULT: ("Correct the block that is named.", "Genannten Satz berichtigen."),
}


def advice(code: int) -> tuple[str, str]:
    """What to do, in English and German; empty where nothing is to be done."""
    return DO.get(Reason(code), ("", "")) if code in Reason._value2member_map_ else ("", "")


def catalogue() -> list[dict[str, object]]:
    """Every number word 1 of a status block may hold."""
    return [
        {
            "code": int(reason),
            "name": reason.name,
            "en": text(reason, "en", "..."),
            "de": text(reason, "de", "..."),
            "do_en": advice(reason)[0],
            "do_de": advice(reason)[1],
        }
        for reason in Reason
        if reason
    ]
