"""The German of the line tools: English sentence, or its pattern, -> German one.  The part after "nach" is in the dative.

Umlauts are written out, for consoles of every code page; {} may be numbered to change their order.
"""

from collections.abc import Mapping

from gateway.pure.lines.texts_de_jobs import JOBS
from gateway.pure.lines.texts_de_reports import CP341, DIAGNOSIS, REPORT, S5

VERDICTS = {
    "PASS": "BESTANDEN",
    "FAIL": "FEHLER",
    "WARN": "WARNUNG",
    "INCONCLUSIVE": "OHNE AUSSAGE",
    "NOT RUN": "ENTFALLEN",
}
LEVELS = {"fault": "Fehler", "warn": "Warnung", "ok": "gut", "note": "Hinweis"}
BENCH = {
    "nothing": "nichts",
    "a damaged character": "ein verstuemmeltes Zeichen",
    "a good block": "einem guten Block",
    "the stimulus": "dem Anstoss",
    "DLE after STX": "DLE nach STX",
    "the station does not fall silent": "die Station wird nicht still",
    "{} after {}": "{} nach {}",
    "the station is not made to send (--stimulus none)": "die Station wird nicht zum Senden gebracht (--stimulus none)",
    "{} cannot send {}": "{} kann {} nicht senden",
    "a character with wrong parity": "ein Zeichen mit falscher Paritaet",
    "block check {}, expected {:02X}h": "Blockpruefzeichen {}, erwartet {:02X}h",
    "after {}: {}, expected {} after {:.0f} ms": "nach {}: {}, erwartet {} nach {:.0f} ms",
    "after {}: {}, expected silence for {:.0f} ms": "nach {}: {}, erwartet Stille fuer {:.0f} ms",
    "{}: {:.1f} ms, expected {:.0f} ms, tolerance {:.1f} ms": "{}: {:.1f} ms, erwartet {:.0f} ms, Toleranz {:.1f} ms",
    "after {}: {}, expected DLE": "nach {}: {}, erwartet DLE",
    "no STX within {:.0f} s after {}: it did not send": "kein STX innerhalb von {:.0f} s nach {}: sie hat nicht gesendet",
    "after {}: {}, expected STX": "nach {}: {}, erwartet STX",
    "block check {:02X}h, expected {:02X}h: off by 02h, the station includes STX": (
        "Blockpruefzeichen {:02X}h, erwartet {:02X}h: um 02h falsch, die Station rechnet STX mit"
    ),
    "block check {:02X}h, expected {:02X}h: the station counts a doubled DLE once": (
        "Blockpruefzeichen {:02X}h, erwartet {:02X}h: die Station rechnet ein verdoppeltes DLE einmal"
    ),
    "after {}: {}, expected {}": "nach {}: {}, erwartet {}",
    "inside the station's block: {} after {} data characters": "im Block der Station: {} nach {} Datenzeichen",
    "the station's block has DLE {}: a DLE is doubled or followed by ETX": (
        "im Block der Station steht DLE {}: ein DLE wird verdoppelt, oder ETX folgt"
    ),
    " within {:.0f} ms": " innerhalb von {:.0f} ms",
    "{}{}": "{}{}",
    "the bench itself was {:.0f} ms late": "der Pruefstand selbst kam {:.0f} ms zu spaet",
    "; seen: {}": "; gesehen: {}",
    "a FETCH": "einem FETCH",
}
RECEIVE = {
    "a stray character in idle": "ein fremdes Zeichen in Ruhe",
    "NAK in idle is never answered": "NAK in Ruhe wird nie beantwortet",
    "BREAK in idle is not answered": "BREAK in Ruhe wird nicht beantwortet",
    "STX while the buffer is full": "STX bei vollem Puffer",
    "eight blocks without a pause: is the buffer ever full, and what is said then": (
        "acht Bloecke ohne Pause: wird der Puffer voll, und was kommt dann"
    ),
    "silence after DLE: NAK when the character delay (ZVZ/CDT) is over": "Stille nach DLE: NAK nach der Zeichenverzugszeit (ZVZ/CDT)",
    "silence inside the data: NAK after ZVZ/CDT": "Stille in den Daten: NAK nach ZVZ/CDT",
    "silence before the block check: NAK after ZVZ/CDT": "Stille vor dem Blockpruefzeichen: NAK nach ZVZ/CDT",
    "a pause of nine tenths of ZVZ/CDT is none": "eine Pause von neun Zehnteln der ZVZ/CDT ist keine",
    "a wrong block check: NAK": "falsches Blockpruefzeichen: NAK",
    "a doubled DLE enters the check both times: a check that counts it once is refused": (
        "ein verdoppeltes DLE zaehlt zweimal: ein Pruefzeichen, das es einmal zaehlt, wird abgelehnt"
    ),
    "a block with one DLE in it, its check by the rule: DLE": "ein Block mit einem DLE, Pruefzeichen nach der Regel: DLE",
    "a check that includes STX (off by 02h) is refused": "ein Pruefzeichen mit STX darin (um 02h falsch) wird abgelehnt",
    "the check is missing and STX comes in its place: NAK": "das Pruefzeichen fehlt, an seiner Stelle kommt STX: NAK",
    "DLE followed by neither DLE nor ETX": "auf DLE folgt weder DLE noch ETX",
    "02h inside a block is data": "02h im Block ist ein Datenbyte",
    "15h inside a block is data": "15h im Block ist ein Datenbyte",
    "a block of 1 character": "ein Block von 1 Zeichen",
    "a block of 128 characters": "ein Block von 128 Zeichen",
    "a block as long as the profile allows (138 for RK512)": "ein Block so lang, wie es das Profil erlaubt (138 bei RK512)",
    "one character more: NAK, nothing delivered": "ein Zeichen mehr: NAK, nichts wird abgeliefert",
    "a block of 64 times 10h, every one doubled": "ein Block von 64 mal 10h, jedes verdoppelt",
    "an empty block: any answer, and the link stays good": "ein leerer Block: Antwort beliebig, die Verbindung bleibt gut",
    "DLE ETB ends a block as DLE ETX does": "DLE ETB beendet einen Block wie DLE ETX",
    "a parity error in the data: received to the end, NAK": "Paritaetsfehler in den Daten: bis zum Ende gehoert, NAK",
    "a parity error in the block check: NAK": "Paritaetsfehler im Blockpruefzeichen: NAK",
    "BREAK inside a block: the station leaves it without an answer": "BREAK im Block: die Station bricht ohne Antwort ab",
    "a good block after a bad one, within the block wait time (BWZ)": (
        "ein guter Block nach einem schlechten, innerhalb der Blockwartezeit (BWZ)"
    ),
    "a good block after a bad one, after the block wait time": "ein guter Block nach einem schlechten, nach der Blockwartezeit",
    "seven bad blocks in a row, each NAK, then a good one": "sieben schlechte Bloecke nacheinander, je NAK, dann ein guter",
    "a stray character": "einem fremden Zeichen",
    "NAK in idle": "NAK in Ruhe",
    "BREAK in idle": "BREAK in Ruhe",
    "its DLE and silence": "ihrem DLE und Stille",
    "silence in the data": "Stille in den Daten",
    "silence before the check": "Stille vor dem Pruefzeichen",
    "a short pause": "einer kurzen Pause",
    "a block with a short pause": "einem Block mit kurzer Pause",
    "a wrong block check": "einem falschen Blockpruefzeichen",
    "a check that counts a doubled DLE once": "einem Pruefzeichen, das ein verdoppeltes DLE einmal zaehlt",
    "a block with one doubled DLE and the right check": "einem Block mit einem verdoppelten DLE und richtigem Pruefzeichen",
    "a check that includes STX": "einem Pruefzeichen mit STX darin",
    "STX in place of the check": "STX anstelle des Pruefzeichens",
    "a block with 02h in its data": "einem Block mit 02h in den Daten",
    "a block with 15h in its data": "einem Block mit 15h in den Daten",
    "a block of 64 times 10h": "einem Block von 64 mal 10h",
    "a good block after an empty one": "einem guten Block nach einem leeren",
    "a block with a parity error": "einem Block mit Paritaetsfehler",
    "a damaged check": "einem verstuemmelten Pruefzeichen",
    "BREAK inside a block": "BREAK im Block",
    "its NAK": "ihrem NAK",
    "the repeat within the block wait time": "der Wiederholung innerhalb der Blockwartezeit",
    "a block after the block wait time": "einem Block nach der Blockwartezeit",
    "a good block after seven bad ones": "einem guten Block nach sieben schlechten",
    "this station has no command to keep its buffer full; see idle.fill": (
        "dieser Station kann man nicht befehlen, ihren Puffer voll zu lassen; siehe idle.fill"
    ),
    "took {} blocks: the buffer cannot be filled from the line": "nahm {} Bloecke: der Puffer ist von der Leitung her nicht zu fuellen",
    "procedure 3964 has no block check": "die Prozedur 3964 hat kein Blockpruefzeichen",
    "NAK after {}": "NAK nach {}",
    "the block check is {:02X}h: sent once, read as it is": "das Blockpruefzeichen ist {:02X}h: einmal gesendet, gelesen wie es ist",
    "DLE and another character": "DLE und einem anderen Zeichen",
    "answers {}; the sources leave the choice open": "antwortet {}; die Quellen lassen die Wahl offen",
    "NAK: this station does not know DLE ETB, which only process computers send": (
        "NAK: diese Station kennt DLE ETB nicht, das nur Prozessrechner senden"
    ),
    "a bad block": "einem schlechten Block",
    "NAK after STX with a full buffer": "NAK nach STX bei vollem Puffer",
    "after {}: nothing, expected NAK": "nach {}: nichts, erwartet NAK",
    "after {}: {}, expected NAK": "nach {}: {}, erwartet NAK",
    "a block whose check is {:02X}h": "einem Block mit dem Pruefzeichen {:02X}h",
    "after an empty block: {}, expected DLE or NAK": "nach einem leeren Block: {}, erwartet DLE oder NAK",
    "after a block that ends with DLE ETB: {}, expected DLE": "nach einem Block mit DLE ETB am Ende: {}, erwartet DLE",
    "the buffer was full after {} blocks": "der Puffer war nach {} Bloecken voll",
    "STX of block {}: {}, expected DLE, or NAK after {:.0f} ms": "STX von Block {}: {}, erwartet DLE, oder NAK nach {:.0f} ms",
    "a block of {} characters": "einem Block von {} Zeichen",
}
SEND = {
    "a block of its own: form, doubling, check; nothing follows our DLE": (
        "ein eigener Block: Form, Verdoppelung, Pruefzeichen; nach unserem DLE folgt nichts"
    ),
    "the partner is silent: attempts, each after the acknowledgement delay (QVZ/ADT), then it gives up": (
        "der Partner schweigt: Versuche, je nach der Quittungsverzugszeit (QVZ/ADT), dann gibt sie auf"
    ),
    "STX is answered with NAK: repeated at once, so many attempts": "STX wird mit NAK beantwortet: sofort wiederholt, so viele Versuche",
    "STX is answered with another character": "STX wird mit einem anderen Zeichen beantwortet",
    "STX is answered with a damaged character": "STX wird mit einem verstuemmelten Zeichen beantwortet",
    "DLE just before the acknowledgement delay is over": "DLE kurz vor Ende der Quittungsverzugszeit",
    "no answer: STX again when QVZ is over, and that one is answered": "keine Antwort: nach QVZ wieder STX, und das wird beantwortet",
    "NAK while the block is under way: it begins again with STX": "NAK waehrend der Block laeuft: sie beginnt wieder mit STX",
    "NAK after the block: begins again with STX, same block": "NAK nach dem Block: beginnt wieder mit STX, derselbe Block",
    "another character after the block: begins again": "ein anderes Zeichen nach dem Block: beginnt neu",
    "silence after the block: STX again after QVZ/ADT": "Stille nach dem Block: wieder STX nach QVZ/ADT",
    "every block is answered with NAK: so many block attempts, then it gives up": (
        "jeder Block wird mit NAK beantwortet: so viele Blockversuche, dann gibt sie auf"
    ),
    "STX is answered with DLE DLE": "STX wird mit DLE DLE beantwortet",
    "DLE after it gave up is a stray character: no block follows": "DLE nach dem Aufgeben ist ein fremdes Zeichen: kein Block folgt",
    "both send STX: the station without priority withdraws, keeps its job, sends it afterwards": (
        "beide senden STX: die Station ohne Prioritaet tritt zurueck, behaelt ihren Auftrag, sendet ihn danach"
    ),
    "the conflict comes in a repeat": "der Konflikt kommt bei einer Wiederholung",
    "five conflicts in a row: no job is lost on either side": "fuenf Konflikte nacheinander: auf keiner Seite geht ein Auftrag verloren",
    "both have the same priority: it ends by the rule, and the link is good afterwards": (
        "beide haben dieselbe Prioritaet: es endet nach der Regel, danach ist die Verbindung gut"
    ),
    "the acknowledged block": "dem quittierten Block",
    "connection attempts": "Verbindungsversuche",
    "connection attempt": "Verbindungsversuch",
    "STX, before QVZ is over": "STX, vor Ablauf der QVZ",
    "STX and silence": "STX und Stille",
    "the block and silence": "dem Block und Stille",
    "block attempts": "Blockversuche",
    "block attempt": "Blockversuch",
    "a DLE after giving up": "einem DLE nach dem Aufgeben",
    "; it behaves as with priority": "; sie verhaelt sich wie mit Prioritaet",
    "; it behaves as without priority": "; sie verhaelt sich wie ohne Prioritaet",
    "; it refuses a conflicting STX": "; sie lehnt ein STX im Konflikt ab",
    "NAK to STX": "NAK auf STX",
    "a good block after the conflict": "einem guten Block nach dem Konflikt",
    "DLE in place of a block": "DLE anstelle eines Blocks",
    "connection attempts with both stations high": "Verbindungsversuche, beide Stationen mit Prioritaet",
    "connection attempt with both stations high": "Verbindungsversuch, beide Stationen mit Prioritaet",
    "{} characters: {}{}": "{} Zeichen: {}{}",
    "connection attempts when STX is answered with {}": "Verbindungsversuche, wenn auf STX {} kommt",
    "connection attempt when STX is answered with {}": "Verbindungsversuch, wenn auf STX {} kommt",
    "this profile gives up after one silence": "dieses Profil gibt nach einem Schweigen auf",
    "{} after the block": "{} nach dem Block",
    "the repeated block differs from the first": "der wiederholte Block ist anders als der erste",
    "our block in a conflict": "unserem Block im Konflikt",
    "our block after the second conflict": "unserem Block nach dem zweiten Konflikt",
    "{} {}, expected {}": "{} {}, erwartet {}",
    "after the last attempt: {}, expected {} when it gives up": "nach dem letzten Versuch: {}, erwartet {} beim Aufgeben",
    "after NAK inside the block: {} at last, expected STX": "nach NAK im Block: zuletzt {}, erwartet STX",
    "with priority it must ignore our STX and wait: {}{}": "mit Prioritaet muss sie unser STX uebergehen und warten: {}{}",
    "both without priority, after our STX: {}, expected DLE": "beide ohne Prioritaet, nach unserem STX: {}, erwartet DLE",
    "STX {} after a conflict in which neither side gives way": "STX {} nach einem Konflikt, in dem niemand nachgibt",
    "{} after STX {} and silence": "{} nach STX {} und Stille",
    "without priority it must withdraw and answer our STX with DLE: {}{}": (
        "ohne Prioritaet muss sie zuruecktreten und unser STX mit DLE beantworten: {}{}"
    ),
    "after our block it must send its own job: {}, its job is lost": (
        "nach unserem Block muss sie ihren eigenen Auftrag senden: {}, ihr Auftrag ist verloren"
    ),
}
RK512 = {
    "no error": "kein Fehler",
    "access to the area not possible or not allowed": "Zugriff auf den Bereich nicht moeglich oder nicht erlaubt",
    "data type not valid": "Datentyp ungueltig",
    "header error, or follow-on telegrams not supported": "Kopf falsch, oder Folgetelegramme nicht moeglich",
    "type not supported": "Typ nicht bedient",
    "block missing or too short": "Baustein fehlt oder ist zu kurz",
    "command (byte 3) wrong": "Befehl (Byte 3) falsch",
    "partner CPU in STOP": "CPU des Partners in STOP",
    "locked by coordination flag": "durch Koordinierungsmerker gesperrt",
    "length wrong": "Laenge falsch",
    "sequence: follow-on without a first telegram": "Reihenfolge: Folgetelegramm ohne erstes",
    "a command telegram": "einem Befehlstelegramm",
    "STX of the reaction": "STX der Reaktion",
    "a number outside the tables": "eine eigene Nummer",
    "FETCH of one word and of {} words ({} bytes): error number 00 and as many bytes": (
        "FETCH von einem Wort und von {} Worten ({} Bytes): Fehlernummer 00 und ebenso viele Bytes"
    ),
    "SEND writes back what FETCH read; the reaction is 4 bytes with 00": (
        "SEND schreibt zurueck, was FETCH gelesen hat; die Reaktion sind 4 Bytes mit 00"
    ),
    "a header that holds 10h three times (FETCH DB 16 DW 16, 16 words)": "ein Kopf mit dreimal 10h (FETCH DB 16 DW 16, 16 Worte)",
    "a coordination flag in bytes 9 and 10": "ein Koordinierungsmerker in Byte 9 und 10",
    "refused with {:02X}h ({}), expected {:02X}h ({})": "abgelehnt mit {:02X}h ({}), erwartet {:02X}h ({})",
    "10h written into the block comes back whole: the station doubles every DLE it sends": (
        "10h im Baustein kommt heil zurueck: die Station verdoppelt jedes DLE, das sie sendet"
    ),
    "{} was written, {} came back": "{} wurde geschrieben, {} kam zurueck",
    "STX is answered with {} after {:.1f} s: later than the acknowledgement delay allows": (
        "STX wird nach {1:.1f} s mit {0} beantwortet: spaeter als die Quittungsverzugszeit erlaubt"
    ),
    "the partner is present but slow: a busy program, or a converter in between; a longer QVZ (ack_delay) on our side allows for it": (
        "der Partner ist da, aber langsam: ausgelastetes Programm oder Umsetzer dazwischen; eine laengere QVZ (ack_delay) bei "
        "uns laesst ihn zu"
    ),
    "Conclusion: no statement about the station: no test was completed.": (
        "Ergebnis: ueber die Station laesst sich nichts sagen: kein Test wurde zu Ende gefuehrt."
    ),
    "Conclusion: the station does not speak {} here: none of {} tests passed; axisgate line diagnose finds the cause.": (
        "Ergebnis: die Station spricht hier kein {}: keiner von {} Tests ist bestanden; axisgate line diagnose sucht die Ursache."
    ),
    "Conclusion: the station does not comply with {}: {} of {} tests fail, the first is {} ({}).": (
        "Ergebnis: die Station haelt {} nicht ein: {} von {} Tests sind nicht bestanden, der erste ist {} ({})."
    ),
    "Conclusion: the station speaks {}; {} of {} tests show a difference that its partner must allow.": (
        "Ergebnis: die Station spricht {}; {} von {} Tests zeigen eine Abweichung, die ihr Partner dulden muss."
    ),
    "Conclusion: no test contradicts {}, but {} tests are inconclusive: the bench was late; try again.": (
        "Ergebnis: nichts spricht gegen {}, aber {} Tests sind ohne Aussage: der Pruefstand war zu spaet; wiederholen."
    ),
    "Conclusion: the station speaks {} in all {} tests that were run; not run: {}.": (
        "Ergebnis: die Station spricht {} in allen {} ausgefuehrten Tests; nicht ausgefuehrt: {}."
    ),
    "Conclusion: the station speaks {} in the one test that was run.": "Ergebnis: die Station spricht {} in dem einen ausgefuehrten Test.",
    "Conclusion: the station does not speak {} here: the one test did not pass; axisgate line diagnose finds the cause.": (
        "Ergebnis: die Station spricht hier kein {}: der eine Test ist nicht bestanden; axisgate line diagnose sucht die Ursache."
    ),
    "Conclusion: the station speaks {} in all {} tests.": "Ergebnis: die Station spricht {} in allen {} Tests.",
    "partner slow": "Partner langsam",
    "3964R and RK512": "3964R und RK512",
    "3964 and RK512": "3964 und RK512",
    "writes into the station; allowed with --write": "schreibt in die Station; erlaubt mit --write",
    "nothing is written: FETCH of the same {} words was answered {}": (
        "nichts geschrieben: FETCH derselben {} Worte wurde mit {} beantwortet"
    ),
    "DB {} is there, a SEND would write into it; --missing-db names one that is not": (
        "DB {} ist vorhanden, ein SEND wuerde hineinschreiben; --missing-db nennt einen, der fehlt"
    ),
    "the station takes more than this profile's {} characters": "die Station nimmt mehr als die {} Zeichen dieses Profils",
    "a block that does not exist": "ein Baustein, den es nicht gibt",
    "SEND to a block that does not exist": "SEND in einen Baustein, den es nicht gibt",
    "words beyond the end of the block": "Worte hinter dem Ende des Bausteins",
    "byte 3 is not one of A, O, E": "Byte 3 ist weder A noch O noch E",
    "byte 4 names no type": "Byte 4 ist kein Typ",
    "byte 1 is neither 00 nor FF": "Byte 1 ist weder 00 noch FF",
    "a follow-on telegram without a first one": "ein Folgetelegramm ohne erstes",
    "a header of 9 bytes": "ein Kopf von 9 Bytes",
    "FETCH with data after the header": "FETCH mit Daten hinter dem Kopf",
    "SEND that brings less than it announces": "SEND bringt weniger, als es ankuendigt",
    "SEND that brings more than it announces": "SEND bringt mehr, als es ankuendigt",
    "SEND with an odd number of bytes": "SEND mit ungerader Anzahl Bytes",
    "an amount of 0": "Anzahl 0",
    "FETCH of {} bytes: follow-on telegrams, or refused as a whole": "FETCH von {} Bytes: Folgetelegramme, oder ganz abgelehnt",
    "FETCH of type {}: served, or refused with a number": "FETCH vom Typ {}: bedient, oder mit Nummer abgelehnt",
    "no reaction telegram within {:.0f} s": "kein Reaktionstelegramm innerhalb von {:.0f} s",
    "after a command telegram: {}, expected the STX of the reaction": "nach einem Befehlstelegramm: {}, erwartet das STX der Reaktion",
    "reaction {}: 00 (or FF) 00 00 and an error number expected": "Reaktion {}: erwartet 00 (oder FF) 00 00 und eine Fehlernummer",
    "executed (00h), expected refusal {:02X}h": "ausgefuehrt (00h), erwartet Ablehnung {:02X}h",
    "error {:02X}h with {} data bytes after it, none may follow": "Fehler {:02X}h mit {} Datenbytes dahinter, keine duerfen folgen",
    "executed: the flag was free or is not checked": "ausgefuehrt: der Merker war frei oder wird nicht beachtet",
    "32h: locked, or flags are not served": "32h: gesperrt, oder Merker werden nicht bedient",
    "{}: {:02X}h": "{}: {:02X}h",
    "{}; {:02X}h is in no table": "{}; {:02X}h steht in keiner Tabelle",
    "SEND of {} words: reaction {}, expected 00 00 00 00": "SEND von {} Worten: Reaktion {}, erwartet 00 00 00 00",
    "{} bytes, expected 32": "{} Bytes, erwartet 32",
    "{:02X}h ({}): the header was not read as it was sent": "{:02X}h ({}): der Kopf wurde nicht gelesen, wie er gesendet war",
    "{:02X}h ({}), expected 00h or 32h": "{:02X}h ({}), erwartet 00h oder 32h",
    "DB {} has {} words for the probe (--words)": "DB {} hat {} Worte fuer die Pruefung (--words)",
    "refused with {:02X}h: no follow-on telegrams here, at most 128 bytes in a job": (
        "abgelehnt mit {:02X}h: hier keine Folgetelegramme, hoechstens 128 Bytes je Auftrag"
    ),
    "{} of {} bytes, last reaction {}": "{} von {} Bytes, letzte Reaktion {}",
    "{} bytes, expected {}": "{} Bytes, erwartet {}",
    "refused with {:02X}h and {} data bytes": "abgelehnt mit {:02X}h und {} Datenbytes",
    "not served: {:02X}h ({})": "nicht bedient: {:02X}h ({})",
    "served": "bedient",
    "FETCH DB {} DW {}, {} words: {:02X}h ({})": "FETCH DB {} DW {}, {} Worte: {:02X}h ({})",
    "FETCH of {} words brought {} bytes, expected {}": "FETCH von {} Worten brachte {} Bytes, erwartet {}",
    "a piece of {} bytes, expected 128": "ein Stueck von {} Bytes, erwartet 128",
    "the right reaction: no repeat, no complaint": "die richtige Reaktion: keine Wiederholung, keine Beschwerde",
    "a reaction with error number 14h": "eine Reaktion mit Fehlernummer 14h",
    "a reaction whose first byte is 55h": "eine Reaktion, deren erstes Byte 55h ist",
    "a reaction of 3 bytes": "eine Reaktion von 3 Bytes",
    "a reaction with two bytes too many": "eine Reaktion mit zwei Bytes zu viel",
    "a command telegram in place of the reaction": "ein Befehlstelegramm anstelle der Reaktion",
    "no reaction at all": "gar keine Reaktion",
    "the job after that": "dem Auftrag danach",
    "the right reaction to the next job": "der richtigen Reaktion auf den naechsten Auftrag",
    "the station's block {} is not an RK512 command": "der Block {} der Station ist kein RK512-Befehl",
    "a reaction telegram": "einem Reaktionstelegramm",
    "a command whose reaction never arrives": "einem Befehl, dessen Reaktion nie kommt",
    "after the right reaction: {}": "nach der richtigen Reaktion: {}",
}
GERMAN: Mapping[str, str] = {**VERDICTS, **LEVELS, **BENCH, **RECEIVE, **SEND, **RK512, **REPORT, **DIAGNOSIS, **S5, **CP341, **JOBS}
