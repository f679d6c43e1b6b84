"""Sentences of the PHG in German; the labels of its keys are the manual's.  Pure."""

from gateway.pure.controllers.reis.pendant import menus

GERMAN = {
    menus.FILES: "ein neues Programm ist eine Datei: in den Ordner der Zelle legen",
    menus.MARKS: "keine Markierung: Löschen, Kopieren, Umbenennen nehmen ein Programm",
    menus.EDITOR: "Schritte werden in der Programmdatei geändert; START liest sie neu",
    menus.SERVICE: "nur für den Kundendienst: nicht in dieser Steuerung",
    menus.NONE: "auch im ROBOTstar ohne Funktion",
    menus.NO_DISK: "diese Steuerung hat kein Diskettenlaufwerk: Dateien in den Ordner kopieren",
    menus.CLOCK: "die Uhr ist die des Rechners: dort stellen",
    menus.WINDOWS: "hier ein Fenster: das Handgerät ein zweites Mal öffnen",
    menus.REFERENCE: "Achsen referenzieren: RC-Eingänge, Seite Achsen oder axisgate jog",
    "the test display of the PLC is on the page PLC": "die Testanzeige der SPS ist auf der Seite SPS",
    "this control has no DNC interface": "diese Steuerung hat keine DNC-Schnittstelle",
    "this control has no archive": "diese Steuerung hat kein Archiv",
    "access level": "Zugriffsstufe",
    "needs code word 1": "braucht Codewort 1",
    "needs code word 2": "braucht Codewort 2",
    "needs the PIN": "braucht die PIN",
    "code word:": "Codewort:",
    "unknown code word": "Codewort unbekannt",
    "this cell has no code words": "diese Zelle hat keine Codewörter",
    "name of the program:": "Programmname:",
    "search for:": "suchen:",
    "not found": "nicht gefunden",
    "variable:": "Variable:",
    "step:": "Schritt:",
    "acknowledge the program to be deleted:": "zu löschendes Programm bestätigen:",
    "acknowledge the source program:": "Quellprogramm bestätigen:",
    "new program name:": "neuer Programmname:",
    "letters to lock of LAESU, - for none:": "zu sperrende Buchstaben von LAESU, - für keinen:",
    "AUTO is RC input 23": "AUTO ist RC-Eingang 23",
    "in AUTO: RC input 23 ends it": "in AUTO: RC-Eingang 23 beendet es",
    "no such step": "kein solcher Schritt",
    "no memory: [controller] memory names its folder": "kein Speicher: [controller] memory nennt seinen Ordner",
    "hold the movement key: it moves for as long as it is held": "Verfahrtaste halten: bewegt, solange sie gehalten wird",
    "movement keys need control: request it first": "Verfahrtasten brauchen die Steuerhoheit: erst anfordern",
    "too many orders wait": "zu viele Aufträge warten",
    "movement keys act in HAND": "Verfahrtasten wirken in HAND",
    "Position Control needs tXYZ or tUVW": "Position Control braucht tXYZ oder tUVW",
    "set the override above 0 first": "erst den Override über 0 stellen",
    "messages that stay are hidden until the drives are on": "anstehende Meldungen verborgen, bis die Antriebe ein sind",
    "the PLC is started": "die SPS wird gestartet",
    "this cell has no integrated PLC": "diese Zelle hat keine integrierte SPS",
    "done": "erledigt",
    "close the entry first: ENTER or QUIT": "erst die Eingabe beenden: ENTER oder QUIT",
    "no value": "kein Wert",
    "not synchronous": "nicht synchron",
    "no kinematics: no Cartesian position": "keine Kinematik: keine kartesische Position",
}


def say(words: str, language: str) -> str:
    """In the language of the cell; what is not in the table stays."""
    return GERMAN.get(words, words) if language == "de" else words
