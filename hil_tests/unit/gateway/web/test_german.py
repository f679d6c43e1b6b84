"""German on the page: umlauts, and errors in the page's language whatever the language of the cell."""

import pytest

from gateway.files.error_catalogue import explain
from gateway.pure.image.reasons import Reason, text
from gateway.web.catalogue import found
from gateway.web.german import both, umlauts

STAY = "Befehlsquelle, Steuerung, Quelle, neue, Dauer, aktuelle, zuerst, SET_VALUE, muss, dass, Masse, Messsystem, fasst, passt"


@pytest.mark.parametrize(
    "written, shown",
    [
        ("Ziel ausserhalb der Grenzen, Einheit pruefen", "Ziel außerhalb der Grenzen, Einheit prüfen"),
        (STAY, STAY),
        ("Massstab groesser, Kette schliessen", "Maßstab größer, Kette schließen"),
        ("Stoerung: Ueberdrehzahl am Geraet, Schluessel, Dauerueberstrom", "Störung: Überdrehzahl am Gerät, Schlüssel, Dauerüberstrom"),
        ("liess, verliess, heisst, laesst, Schuetze, zulaessig", "ließ, verließ, heißt, lässt, Schütze, zulässig"),
    ],
)
def test_umlauts_are_written_as_in_print(written: str, shown: str) -> None:
    assert umlauts(written) == shown


def test_an_error_is_reported_in_both_languages() -> None:
    for reason in Reason:
        for language in ("en", "de"):
            told = both(int(reason), text(reason, language, "A2 7"))
            assert told[0] == text(reason, "en", "A2 7") and told[1] == umlauts(text(reason, "de", "A2 7")), reason
    assert both(999, "something else") == ["something else"] * 2


def test_the_catalogue_shows_print_letters_and_the_partners_own_words() -> None:
    pages = {(row["family"], row["code"]): row for row in found("axisgate")}
    shown = str([row[part] for row in pages.values() for part in ("text", "do", "cause")])
    for word in ("pruef", "laeuft", "fuer", "ausserhalb", "Stoerung"):
        assert word not in shown
    entry = explain("axisgate 4")[0]
    assert found("axisgate 4")[0]["shown"] == [entry.shown.en, entry.shown.de], "what the partner sees is quoted"
