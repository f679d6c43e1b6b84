"""Two mistakes of a maintenance engineer, one beside the other, are two faults in their lines, and the hint says what was meant."""

import pytest

from hil_tests.unit.languages.baps2.running import body, faults_of, library_of, run, short, written

PALLET = """;;KINEMATIK : ( 1 = PORTAL )
;;PORTAL.WK_NAMEN = X, Y, Z, C
PROGRAMM PALETT
EINGANG : 1 = TEIL_DA, 2 = PAL_DA
AUSGANG : 1 = GREIFER
KONST : REIHEN = 2, RASTER = 50.0
GANZ : ZEILE, ANZAHL
DEZ : HOEHE
DEF PORTAL.PUNKT : ABHOL, PAL_0
ANFANG
WARTE BIS PAL_DA = 1 MAX_ZEIT = 5 FEHLER SPRUNG LEER
HOEHE = 12.5
WDH REIHEN MAL
  FAHRE LINEAR UEBER ABHOL NACH PAL_0
  WARTE 0.3
  PAL_0.X = PAL_0.X + ZEILE * RASTER
  WENN TEIL_DA = 0 UND ZEILE < 5
  DANN GREIFER = 0
  SONST GREIFER = 1
  ZEILE = ZEILE + 1
WDH_ENDE
FALLS ANZAHL
GLEICH 1, 2 : GREIFER = 0
GLEICH 3 : ABLEGE (ANZAHL, HOEHE)
FALLS_ENDE
LEER: SCHREIBE 'leer'
PROGRAMM_ENDE
UP ABLEGE (WERT GANZ : NR DEZ : H)
ANFANG
  H = H + NR
UP_ENDE
"""
PAIRS = [
    ("GANZ : ZEILE, ANZAHL", "GANZ : ZEILE ANZAHL", "DEZ : HOEHE", "DEZ HOEHE"),
    ("GANZ : ZEILE", "GANZ ; ZEILE", "DEZ : HOEHE", "DEZZ : HOEHE"),
    ("1 = TEIL_DA", "1 TEIL_DA", "AUSGANG : 1", "AUSGANG = 1"),
    ("RASTER = 50.0", "RASTER = 50,0", "GANZ : ZEILE", "GNAZ : ZEILE"),
    ("MAX_ZEIT = 5", "MAXZET = 5", "HOEHE = 12.5", "HOEHE == 12.5"),
    ("REIHEN MAL", "REIHEN MALL", "UEBER ABHOL", "\u00dcBER ABHOL"),
    ("WARTE 0.3", "WARTE 0,3", "PAL_0.X = PAL_0", "PAL_0.X := PAL_0"),
    ("UND ZEILE < 5", "UND ZEILE > < 5", "DANN GREIFER", "DAN GREIFER"),
    ("SONST GREIFER", "SONNST GREIFER", "ZEILE + 1", "ZEILLE + 1"),
    ("ZEILE + 1", "ZIELE + 1", "WDH_ENDE", "WDH ENDE"),
    ("FALLS ANZAHL", "FALL ANZAHL", "GLEICH 1, 2 :", "GLEICH 1, 2 ="),
    ("(ANZAHL, HOEHE)", "(ANZAHL HOEHE)", "FALLS_ENDE", "FALLSENDE"),
    ("LEER: SCHR", "LEER SCHR", "PROGRAMM_ENDE", "PROGRAMMENDE"),
    ("WERT GANZ : NR", "WERT GANZ NR", "H = H + NR", "H = H + NF"),
]


def test_the_program_itself_is_sound() -> None:
    assert faults_of(PALLET) == []


@pytest.mark.parametrize("first, wrong, second, wrong_too", PAIRS)
def test_two_mistakes_are_two_faults(first: str, wrong: str, second: str, wrong_too: str) -> None:
    lines = [PALLET[: PALLET.index(each)].count("\n") + 1 for each in (first, second)]
    text = PALLET.replace(first, wrong, 1).replace(second, wrong_too, 1)
    assert [line for _, line in faults_of(text)] == lines


@pytest.mark.parametrize(
    "statements, hint",
    [
        ("ZEILLE = 1", "did you mean ZEILE?"),
        ("SPRUNG SCHLUS\nSCHLUSS:", "did you mean SCHLUSS?"),
        ("MELD\nHALT", "did you mean MELDE?"),
        ("WARTE 1,5", "write 1.5"),
        ("ZEILE := 1", "write ="),
        ("PARALLEL\nALSO\nPARALLEL ENDE", "write PARALLEL_ENDE"),
        ("V_PTB = 1", "did you mean V_PTP?"),
        ("NR = 1", "line 2 has it in a comment after a semicolon"),
    ],
)
def test_the_hint_says_what_was_meant(statements: str, hint: str) -> None:
    text = f"PROGRAMM P\nGANZ : ZEILE; NR\nANFANG\n{statements}\nPROGRAMM_ENDE\nUP MELDE\nANFANG\nUP_ENDE\n"
    assert [fault.hint for fault in library_of({}).check("P.QLL", text)[1]] == [hint]


@pytest.mark.parametrize("name, kind", [("E", "an input"), ("O", "an output"), ("I", "a variable")])
def test_what_is_started_and_is_no_program_is_named_with_its_article(name: str, kind: str) -> None:
    text = body(f"START {name}", "INPUT : 1 = E OUTPUT : 1 = O INTEGER : I")
    assert [fault.text for fault in library_of({}).check("P.QLL", text)[1]] == [f"{name} is {kind}, not a program"]


ENGLISH = """PROGRAM P
INTEGER : NO, WERT
BINARY : FEHLER
INPUT : 3 = BAND
ARRAY[1..3] INTEGER : FELD
BEGIN
WERT = 3
FELD[1] = WERT
IF FEHLER = 1 THEN JUMP ENDE
WAIT UNTIL BAND = 1 MAX_TIME = 1 ERROR SONST
FEHLER = 0
MOVE TO UEBER
ENDE:
WRITE WERT, FELD[1]
PROGRAM_END
SR SONST
BEGIN
WRITE 'no belt'
SR_END
"""


def test_german_words_are_names_in_an_english_program() -> None:
    events = run(ENGLISH, "[points.P]\nUEBER = [5, 5]")
    assert written(events) == ["no belt", "33"]
    assert short(events, "moved", "error") == [(2.0, "moved", 1)]


def test_english_words_are_names_in_a_german_program() -> None:
    text = "PROGRAMM P\nGANZ : VALUE, TIMES\nEINGANG : 1 = BELT\nANFANG\nVALUE = 2\nWDH VALUE MAL\nTIMES = TIMES + 1\nWDH_ENDE\n"
    text += "WENN BELT = 0 DANN SPRUNG ERROR\nSCHREIBE 'no'\nERROR: SCHREIBE TIMES\nPROGRAMM_ENDE\n"
    assert written(run(text)) == ["2"]


def test_words_of_the_program_s_own_language_stay_words() -> None:
    assert faults_of("PROGRAM P\nBEGIN\nMOVE TO END\nPROGRAM_END\n") == [("syntax", 3)]
    assert faults_of("PROGRAMM P\nANFANG\nSPRUNG ENDE\nPROGRAMM_ENDE\n") == [("syntax", 3)]


def test_up_is_a_name_in_a_german_program_too() -> None:
    text = ";;KINEMATIK : (1 = ROB)\n;;ROB.WK_NAMEN = X\nPROGRAMM P\nAUSGANG : 1 = UP, 2 = DOWN\nGANZ : N\nANFANG\nUP = 1\nN = 3\n"
    text += "WENN UP = 1 UND N > 2 DANN ANFANG\nSCHREIBE N\nENDE\nUP = 0\nMELDE\nDOWN = UP\nSCHREIBE UP\nPROGRAMM_ENDE\n"
    text += "UP MELDE\nANFANG\nSCHREIBE 'hier'\nUP_ENDE\n"
    assert written(run(text)) == ["3", "hier", "0"]
