"""German of `axisgate line send` and `fetch`: why a job failed."""

from collections.abc import Mapping

JOBS: Mapping[str, str] = {
    "no answer to STX within QVZ/ADT {:.0f} ms": "keine Antwort auf STX innerhalb der QVZ/ADT {:.0f} ms",
    "no answer to the block within QVZ/ADT {:.0f} ms": "keine Antwort auf den Block innerhalb der QVZ/ADT {:.0f} ms",
    "NAK to STX": "NAK auf STX",
    "another character than DLE to STX": "ein anderes Zeichen als DLE auf STX",
    "a damaged answer to STX": "verstuemmelte Antwort auf STX",
    "a conflict of both STX": "Konflikt, beide sandten STX",
    "the block refused (NAK)": "Block abgelehnt (NAK)",
    "another character than DLE to the block": "ein anderes Zeichen als DLE auf den Block",
    "a damaged answer to the block": "verstuemmelte Antwort auf den Block",
    "something else": "etwas anderes",
    "{} ({})": "{} ({})",
    "{}; {} ({})": "{}; {} ({})",
    "{}: {}": "{}: {}",
    "1 attempt": "1 Versuch",
    "{} attempts": "{} Versuche",
    "partner off, cable, wires or speed wrong": "Partner aus, Kabel, Adern oder Geschwindigkeit falsch",
    "the partner is not ready, its buffer is full": "der Partner ist nicht bereit, sein Puffer ist voll",
    "wrong speed or parity, echo, or no 3964R": "falsche Geschwindigkeit oder Paritaet, Echo, oder kein 3964R",
    "wrong speed or parity": "falsche Geschwindigkeit oder Paritaet",
    "do both stations have the same priority?": "haben beide Stationen dieselbe Prioritaet?",
    "the partner is busy, or it expects 3964 without block check": (
        "der Partner ist beschaeftigt, oder er erwartet 3964 ohne Blockpruefzeichen"
    ),
    "block check, parity, ZVZ/CDT, or 3964 instead of 3964R at the partner": (
        "Blockpruefzeichen, Paritaet, ZVZ/CDT, oder 3964 statt 3964R beim Partner"
    ),
    "{}; or its {} characters are more than the partner accepts": "{}; oder seine {} Zeichen sind mehr, als der Partner annimmt",
    "the partner answers later than our QVZ/ADT: choose its --profile, or one with a longer QVZ": (
        "der Partner antwortet spaeter als unsere QVZ/ADT: sein --profile waehlen, oder eines mit laengerer QVZ"
    ),
    "both stations have the same priority ({}): set one to high, the other to low": (
        "beide Stationen haben dieselbe Prioritaet ({}): eine auf high setzen, die andere auf low"
    ),
    "the partner sent {} blocks of its own and left no room for our job: it has priority": (
        "der Partner sandte {} eigene Bloecke und liess keinen Platz fuer unseren: er hat Prioritaet"
    ),
    "the reaction telegram could not be taken: {}": "das Reaktionstelegramm konnte nicht angenommen werden: {}",
    "the character delay ZVZ/CDT was exceeded in it; or the partner sends no block check: 3964, not 3964R": (
        "darin wurde die Zeichenverzugszeit ZVZ/CDT ueberschritten; oder der Partner sendet kein Blockpruefzeichen: 3964, nicht 3964R"
    ),
    "a DLE in it was not doubled": "ein DLE darin war nicht verdoppelt",
    "it was longer than the profile allows": "es war laenger, als das Profil erlaubt",
    "its block check was wrong; or the partner sends none: 3964, not 3964R": (
        "sein Blockpruefzeichen war falsch; oder der Partner sendet keines: 3964, nicht 3964R"
    ),
    "it was received damaged: parity or speed": "es kam verstuemmelt an: Paritaet oder Geschwindigkeit",
    "a BREAK ended it": "ein BREAK beendete es",
    "no reaction telegram within {:.0f} s: does the partner speak RK512 (not raw 3964R)?": (
        "kein Reaktionstelegramm innerhalb von {:.0f} s: spricht der Partner RK512 (nicht rohes 3964R)?"
    ),
    "no reaction telegram within {:.0f} s; the partner sent {} commands of its own instead": (
        "kein Reaktionstelegramm innerhalb von {:.0f} s; der Partner sandte stattdessen {} eigene Befehle"
    ),
    "no reaction telegram: {}": "kein Reaktionstelegramm: {}",
    "the partner refuses: {:02X}h, {}": "der Partner lehnt ab: {:02X}h, {}",
    "the reaction to SEND brought {} data bytes, none expected": "die Reaktion auf SEND brachte {} Datenbytes, keine erwartet",
    "the reaction to FETCH of {} words brought {} bytes, expected {}": (
        "die Reaktion auf FETCH von {} Worten brachte {} Bytes, erwartet {}"
    ),
}
