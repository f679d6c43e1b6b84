"""The German of the line tools: English sentence, or its pattern, -> German one.  What stands behind "nach" is in the dative.

Umlauts are written out, for consoles of every code page; {} may be numbered to change their order.
"""

from collections.abc import Mapping

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
    "a parity error in the data: heard to the end, NAK": "Paritaetsfehler in den Daten: bis zum Ende gehoert, NAK",
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
    "this station cannot be told to keep its buffer full; see idle.fill": (
        "dieser Station kann man nicht befehlen, ihren Puffer voll zu lassen; siehe idle.fill"
    ),
    "took {} blocks: the buffer cannot be filled from the line": "nahm {} Bloecke: der Puffer ist von der Leitung her nicht zu fuellen",
    "procedure 3964 has no block check": "die Prozedur 3964 hat kein Blockpruefzeichen",
    "NAK after {}": "NAK nach {}",
    "the block check is {:02X}h: sent once, read as it is": "das Blockpruefzeichen ist {:02X}h: einmal gesendet, gelesen wie es ist",
    "DLE and another character": "DLE und einem anderen Zeichen",
    "answers {}; no source says which": "antwortet {}; keine Quelle sagt was",
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
    "STX, before QVZ is over": "STX, vor Ablauf der QVZ",
    "STX and silence": "STX und Stille",
    "the block and silence": "dem Block und Stille",
    "block attempts": "Blockversuche",
    "a DLE after giving up": "einem DLE nach dem Aufgeben",
    "; it behaves as with priority": "; sie verhaelt sich wie mit Prioritaet",
    "; it behaves as without priority": "; sie verhaelt sich wie ohne Prioritaet",
    "; it refuses a conflicting STX": "; sie lehnt ein STX im Konflikt ab",
    "NAK to STX": "NAK auf STX",
    "a good block after the conflict": "einem guten Block nach dem Konflikt",
    "DLE in place of a block": "DLE anstelle eines Blocks",
    "connection attempts with both stations high": "Verbindungsversuche, beide Stationen mit Prioritaet",
    "{} characters: {}{}": "{} Zeichen: {}{}",
    "connection attempts when STX is answered with {}": "Verbindungsversuche, wenn auf STX {} kommt",
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
    "STX {} after a conflict nobody gives way in": "STX {} nach einem Konflikt, in dem niemand nachgibt",
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
    "a number of its own": "eine eigene Nummer",
    "FETCH of one word and of 64 words (128 bytes): error number 00 and as many bytes": (
        "FETCH von einem Wort und von 64 Worten (128 Bytes): Fehlernummer 00 und ebenso viele Bytes"
    ),
    "SEND writes back what FETCH read; the reaction is 4 bytes with 00": (
        "SEND schreibt zurueck, was FETCH gelesen hat; die Reaktion sind 4 Bytes mit 00"
    ),
    "a header that holds 10h three times (FETCH DB 16 DW 16, 16 words)": "ein Kopf mit dreimal 10h (FETCH DB 16 DW 16, 16 Worte)",
    "a coordination flag in bytes 9 and 10": "ein Koordinierungsmerker in Byte 9 und 10",
    "refused with {:02X}h ({}), expected {:02X}h ({})": "abgelehnt mit {:02X}h ({}), erwartet {:02X}h ({})",
    "writes into the station; allowed with --write": "schreibt in die Station; erlaubt mit --write",
    "a block that does not exist": "ein Baustein, den es nicht gibt",
    "SEND to a block that does not exist": "SEND in einen Baustein, den es nicht gibt",
    "words behind the end of the block": "Worte hinter dem Ende des Bausteins",
    "byte 3 is none of A, O, E": "Byte 3 ist weder A noch O noch E",
    "byte 4 names no type": "Byte 4 ist kein Typ",
    "byte 1 is neither 00 nor FF": "Byte 1 ist weder 00 noch FF",
    "a follow-on telegram without a first one": "ein Folgetelegramm ohne erstes",
    "a header of 9 bytes": "ein Kopf von 9 Bytes",
    "FETCH with data behind the header": "FETCH mit Daten hinter dem Kopf",
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
    "error {:02X}h with {} data bytes behind it, none may follow": "Fehler {:02X}h mit {} Datenbytes dahinter, keine duerfen folgen",
    "executed: the flag was free or is not looked at": "ausgefuehrt: der Merker war frei oder wird nicht beachtet",
    "32h: locked, or flags are not served": "32h: gesperrt, oder Merker werden nicht bedient",
    "{}: {:02X}h": "{}: {:02X}h",
    "{}; {:02X}h stands in no table": "{}; {:02X}h steht in keiner Tabelle",
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
    "the station's block {} is no RK512 command": "der Block {} der Station ist kein RK512-Befehl",
    "a reaction telegram": "einem Reaktionstelegramm",
    "a command whose reaction never comes": "einem Befehl, dessen Reaktion nie kommt",
    "after the right reaction: {}": "nach der richtigen Reaktion: {}",
}
REPORT = {
    "This report states how the tested item behaved in the listed tests on the listed bench. It is not a certificate and not a "
    "conformity test of CAN in Automation, the Modbus Organization or any manufacturer. Results relate only to the item tested. Times "
    "carry the stated uncertainty; tests during which the bench was late are marked inconclusive.": (
        "Dieser Bericht sagt, wie sich das gepruefte Stueck in den genannten Pruefungen am genannten Pruefstand verhalten hat. Er ist kein "
        "Zertifikat und keine Konformitaetspruefung von CAN in Automation, der Modbus Organization oder eines Herstellers. Die Ergebnisse "
        "gelten nur fuer das gepruefte Stueck. Zeiten haben die genannte Unsicherheit; Pruefungen, in denen der Pruefstand selbst zu spaet "
        "kam, sind ohne Aussage."
    ),
    "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Emergency stop, safe torque off, "
    "guards, enabling devices and speed monitoring must be realised in certified hardware that works without axisgate.": (
        "axisgate ist keine Sicherheitseinrichtung. Not-Halt, STO, Schutztueren, Zustimmung und sichere Geschwindigkeit sind in "
        "zertifizierter Hardware auszufuehren, die ohne axisgate wirkt. Grenzwerte in axisgate schuetzen Teile, nicht Personen."
    ),
    "3964R probe": "3964R-Pruefung",
    "one character time and 20 ms; a test in which the bench was later than that is inconclusive": (
        "eine Zeichenzeit und 20 ms; eine Pruefung, in der der Pruefstand spaeter kam, ist ohne Aussage"
    ),
    "Port": "Anschluss",
    "Line": "Leitung",
    "Time": "Zeit",
    "Priority of the station": "Prioritaet der Station",
    "Layer": "Schicht",
    "Uncertainty": "Unsicherheit",
    "Broken off": "Abgebrochen",
    "after {} tests: {}": "nach {} Pruefungen: {}",
    "virtual: the station is simulated in this process": "virtuell: die Station ist in diesem Programm simuliert",
    "real": "wirklich",
    "high": "hoch",
    "low": "niedrig",
    "Profile: {}": "Profil: {}",
    "name": "Name",
    "source": "Quelle",
    "acknowledgement delay QVZ/ADT, ms": "Quittungsverzugszeit QVZ/ADT, ms",
    "character delay ZVZ/CDT, ms": "Zeichenverzugszeit ZVZ/CDT, ms",
    "block wait time BWZ, ms": "Blockwartezeit BWZ, ms",
    "open (no source names it)": "offen (ohne Quelle)",
    "Findings": "Befunde",
    "No findings.": "Keine Befunde.",
    "Tests": "Pruefungen",
    "Test": "Pruefung",
    "Verdict": "Urteil",
    "Reason, measured times, characters": "Grund, gemessene Zeiten, Zeichen",
    "on the wire": "auf der Leitung",
    "{} characters from us, {} from the station; bench late {} ms at most": (
        "{} Zeichen von uns, {} von der Station; Pruefstand hoechstens {} ms zu spaet"
    ),
    "{}: {} ms": "{}: {} ms",
    " (expected {:g} ± {:.1f} ms)": " (erwartet {:g} ± {:.1f} ms)",
    "report: {}.html, {}.json": "Bericht: {}.html, {}.json",
    "do: {}": "tun: {}",
    "Please make the station send now": "Bitte jetzt die Station zum Senden bringen",
}
DIAGNOSIS = {
    "{}: {}": "{}: {}",
    "partner off or its interface not started; TXD and RXD exchanged (cross pins 2 and 3, or TTY sender and receiver); cable": (
        "Partner aus oder seine Schnittstelle nicht gestartet; TXD und RXD vertauscht (2 und 3 kreuzen, oder TTY-Sender und -Empfaenger)"
    ),
    "nothing answers at {}": "niemand antwortet bei {}",
    "wrong speed": "falsche Geschwindigkeit",
    "wrong parity or frame": "falsche Paritaet oder falscher Rahmen",
    "partner silent": "Partner schweigt",
    "the partner answers at {}, not at {}": "der Partner antwortet bei {}, nicht bei {}",
    'set format = "{}"': 'format = "{}" setzen',
    "same priority": "gleiche Prioritaet",
    "both stations have the same priority ({}): whenever both send at once, both jobs wait or fail": (
        "beide Stationen haben dieselbe Prioritaet ({}): senden beide zugleich, warten oder scheitern beide Auftraege"
    ),
    'set ours to priority = "low"': 'unsere auf priority = "low" setzen',
    'set ours to priority = "high"': 'unsere auf priority = "high" setzen',
    "priority": "Prioritaet",
    "the partner has priority {}, we {}": "der Partner hat die Prioritaet {}, wir {}",
    "BCC off by 02h": "BCC um 02h falsch",
    "BCC off by 02h: the partner begins the exclusive or with STX": "BCC um 02h falsch: der Partner beginnt das Exklusiv-Oder mit STX",
    "the partner's software is wrong; STX is not part of the block check": (
        "die Software des Partners ist falsch; STX gehoert nicht ins Blockpruefzeichen"
    ),
    "BCC counts 10h once": "BCC zaehlt 10h einmal",
    "the partner counts a doubled 10h once: blocks with an odd number of 10h are refused both ways": (
        "der Partner zaehlt ein verdoppeltes 10h einmal: Bloecke mit ungerader Zahl von 10h werden in beiden Richtungen abgelehnt"
    ),
    "the partner's software is wrong; both characters of a doubled DLE are in the check": (
        "die Software des Partners ist falsch; beide Zeichen eines verdoppelten DLE gehoeren ins Pruefzeichen"
    ),
    "a FETCH was acknowledged but brought no reaction telegram: raw 3964R blocks, no RK512 (or an active station only)": (
        "ein FETCH wurde quittiert, brachte aber kein Reaktionstelegramm: rohe 3964R-Bloecke, kein RK512 (oder nur eine aktive Station)"
    ),
    "the idle line reads as BREAK or framing errors ({} of them): its polarity is the wrong way round": (
        "die ruhende Leitung liest sich als BREAK oder Rahmenfehler ({}): sie ist verpolt"
    ),
    "wires crossed": "Adern verpolt",
    "exchange the two wires of the receiving pair (A and B, or + and -; TTY: RX+ and RX-)": (
        "die beiden Adern des Empfangspaars tauschen (A und B, oder + und -; TTY: RX+ und RX-)"
    ),
    "line in use": "Leitung belegt",
    "{} characters came while we were silent": "{} Zeichen kamen, waehrend wir schwiegen",
    "is a third station on the line, or is the partner sending by itself?": (
        "ist eine dritte Station an der Leitung, oder sendet der Partner von selbst?"
    ),
    "echo": "Echo",
    "every character comes back ({} of {}): an echo": "jedes Zeichen kommt zurueck ({} von {}): ein Echo",
    "switch the echo of the 2-wire adapter off, or remove the loop-back plug; 3964R needs both directions apart": (
        "das Echo des 2-Draht-Wandlers abschalten oder den Pruefstecker ziehen; 3964R braucht getrennte Richtungen"
    ),
    "cross-talk": "Uebersprechen",
    "of {} characters {} came back right and {} damaged: cross-talk on an open line, not an echo": (
        "von {} Zeichen kamen {} richtig und {} verstuemmelt zurueck: Uebersprechen auf einer offenen Leitung, kein Echo"
    ),
    "the receiving pair is open: partner off, plug out, wire broken, or TTY loop without current": (
        "das Empfangspaar ist offen: Partner aus, Stecker gezogen, Ader gebrochen, oder TTY-Schleife ohne Strom"
    ),
    "something answers, but no DLE: {}": "es antwortet etwas, aber kein DLE: {}",
    "not ready": "nicht bereit",
    "STX is answered with NAK: the partner is there but takes no block": (
        "STX wird mit NAK beantwortet: der Partner ist da, nimmt aber keinen Block"
    ),
    "its buffer is full or its program is in STOP": "sein Puffer ist voll oder sein Programm in STOP",
    "no 3964R": "kein 3964R",
    "3964R": "3964R",
    "RK512": "RK512",
    "STX is answered with DLE at {}": "STX wird bei {} mit DLE beantwortet",
    "is this the right port, and does the partner speak 3964 or 3964R at all?": (
        "ist das der richtige Anschluss, und spricht der Partner ueberhaupt 3964 oder 3964R?"
    ),
    "USB latency timer": "USB-Latenzzeit",
    "the USB adapter's latency timer stands at {} ms: every answer waits up to so long in the adapter": (
        "die Latenzzeit des USB-Wandlers steht auf {} ms: jede Antwort wartet bis zu so lange im Wandler"
    ),
    "answers take {:.0f} ms, as through a USB adapter whose latency timer stands at 16 ms": (
        "Antworten brauchen {:.0f} ms, wie durch einen USB-Wandler, dessen Latenzzeit auf 16 ms steht"
    ),
    "set the adapter's latency timer to 1 ms (Linux: latency_timer in sysfs; Windows: port settings)": (
        "die Latenzzeit des Wandlers auf 1 ms stellen (Linux: latency_timer in sysfs; Windows: Anschlusseinstellungen)"
    ),
    "echo {} | sudo tee {}": "echo {} | sudo tee {}",
    "3964 without R": "3964 ohne R",
    "blocks without check are taken, with check refused: the partner is set to 3964": (
        "Bloecke ohne Pruefzeichen werden genommen, mit Pruefzeichen abgelehnt: der Partner steht auf 3964"
    ),
    'set both to 3964R (or protocol = "3964")': 'beide auf 3964R stellen (oder protocol = "3964")',
    "blocks refused": "Bloecke abgelehnt",
    "a good block is refused with every check tried": "ein guter Block wird mit jedem versuchten Pruefzeichen abgelehnt",
    "parity, or another block format": "Paritaet, oder ein anderes Blockformat",
    "RK512 rides on 3964R{}": "RK512 laeuft auf 3964R{}",
    ", it answered {:02X}h": ", die Antwort war {:02X}h",
    'layer = "rk512"': 'layer = "rk512"',
    "raw 3964R": "rohes 3964R",
    'layer = "telegrams"; describe the blocks with [[telegram]]': 'layer = "telegrams"; die Bloecke mit [[telegram]] beschreiben',
    "refuses conflicts": "lehnt Konflikte ab",
    "the partner answers a conflicting STX with NAK": "der Partner beantwortet ein STX im Konflikt mit NAK",
    "avoid sending at once; leave sending to one side": "nicht zugleich senden; das Senden einer Seite ueberlassen",
}
S5 = {
    "no parameter error": "kein Parametrierfehler",
    "the parameters of the handling block, not the line": "die Parameter des Hantierungsbausteins, nicht die Leitung",
    "PAFE {:02X}h": "PAFE {:02X}h",
    "wrong ORG format, or type of source or destination not allowed": "ORG-Format falsch, oder Typ von Quelle oder Ziel unzulaessig",
    "area does not exist (data block missing or not allowed)": "Bereich nicht vorhanden (Datenbaustein fehlt oder unzulaessig)",
    "area too short": "Bereich zu klein",
    "QVZ: no access possible (acknowledgement delay of the memory or interface)": (
        "QVZ: kein Zugriff moeglich (Quittungsverzug des Speichers oder der Schnittstelle)"
    ),
    "status word (ANZW) wrong": "Anzeigenwort (ANZW) fehlerhaft",
    "no source or destination parameters for SEND ALL / RECEIVE ALL": "keine Quell- oder Zielparameter fuer SEND ALL / RECEIVE ALL",
    "interface does not exist (SSNR)": "Schnittstelle nicht vorhanden (SSNR)",
    "interface not ready: CP not synchronised, or in STOP": "Schnittstelle nicht bereit: CP nicht synchronisiert, oder in STOP",
    "interface overloaded": "Schnittstelle ueberlastet",
    "interface busy with another job": "Schnittstelle durch anderen Auftrag belegt",
    "job number (ANR) not allowed": "Auftragsnummer (ANR) unzulaessig",
    "interface (CP) does not acknowledge, or negatively": "Schnittstelle (CP) quittiert nicht oder negativ",
    "parameter BLGR (block size) not allowed": "Parameter BLGR (Blockgroesse) unzulaessig",
    "fault in the handling block": "Fehler im Hantierungsbaustein",
    "handling block called twice or not allowed here": "Hantierungsbaustein doppelt aufgerufen oder hier unzulaessig",
    "ANZW bit {}": "ANZW Bit {}",
    "ANZW error {:X}h": "ANZW Fehler {:X}h",
    "ANZW {:04X}h": "ANZW {:04X}h",
    "no bit is set: the job was never started": "kein Bit gesetzt: der Auftrag wurde nie angestossen",
    "error of the CP, number {:X}h: its manual names it; on 3964R mostly no connection or a negative reaction": (
        "Fehler des CP, Nummer {:X}h: sein Handbuch nennt ihn; bei 3964R meist keine Verbindung oder eine negative Reaktion"
    ),
    "receive possible (handshake makes sense)": "Empfang moeglich (Handshake sinnvoll)",
    "job runs": "Auftrag laeuft",
    "job ended without error": "Auftrag fertig ohne Fehler",
    "job ended with error": "Auftrag fertig mit Fehler",
    "data transfer runs": "Datentransfer laeuft",
    "data handed to the CP": "Daten an den CP uebergeben",
    "data taken from the CP": "Daten vom CP uebernommen",
    "data block locked": "Datenblock gesperrt",
    "the CP has set the job up again after a restart": "der CP hat den Auftrag nach einem Neustart neu angelegt",
}
CP341 = {
    "({:02X}){:02X}h": "({:02X}){:02X}h",
    "class {} is not in the table; known: {}": "Klasse {} steht nicht in der Tabelle; bekannt: {}",
    "this number is not in our table; the CP's manual names it": "diese Nummer fehlt in unserer Tabelle; das Handbuch des CP nennt sie",
    "start of the CP": "Anlauf des CP",
    "hardware fault of the CP": "Hardwarefehler des CP",
    "fault at initialisation: parameters missing or wrong": "Fehler beim Initialisieren: Parameter fehlen oder sind falsch",
    "parameters of the function blocks wrong": "Parameter der Funktionsbausteine falsch",
    "fault in the traffic between CP and CPU": "Fehler im Verkehr zwischen CP und CPU",
    "fault in a job of the own CPU": "Fehler bei einem Auftrag der eigenen CPU",
    "fault in a job of the partner (RK512): what we sent was refused": (
        "Fehler bei einem Auftrag des Partners (RK512): was wir sandten, wurde abgelehnt"
    ),
    "send fault": "Sendefehler",
    "receive fault": "Empfangsfehler",
    "the partner's reaction carried an error number (RK512)": "das Reaktionstelegramm des Partners trug eine Fehlernummer (RK512)",
    "fault in the partner's reaction, seen by the CP (RK512)": "Fehler im Reaktionstelegramm des Partners, vom CP erkannt (RK512)",
    "fault of a loaded driver": "Fehler eines geladenen Treibers",
    "fault between function block and CP": "Fehler zwischen Funktionsbaustein und CP",
    "byte 1 of the command is neither 00 nor FF": "Byte 1 des Befehls ist weder 00 noch FF",
    "byte 4 (type) wrong or not allowed at the CP": "Byte 4 (Typ) falsch oder beim CP unzulaessig",
    "byte 5: data block number not allowed": "Byte 5: Nummer des Datenbausteins unzulaessig",
    "bytes 5/6: start address too high": "Byte 5/6: Anfangsadresse zu hoch",
    "bytes 7/8: amount not allowed": "Byte 7/8: Anzahl unzulaessig",
    "sequence; normal after a restart of either side": "Reihenfolge; normal nach einem Neustart einer Seite",
    "data block locked by the coordination flag": "Datenbaustein durch den Koordinierungsmerker gesperrt",
    "telegram too short: below 10 bytes, follow-on and reaction below 4": (
        "Telegramm zu kurz: unter 10 Bytes, Folge- und Reaktionstelegramm unter 4"
    ),
    "length in the header and bytes received differ": "Laenge im Kopf und empfangene Bytes sind verschieden",
    "first repeat: the partner answered the block with NAK, or a fault was seen": (
        "erste Wiederholung: der Partner beantwortete den Block mit NAK, oder ein Fehler wurde erkannt"
    ),
    "STX was answered with NAK or a character that is neither DLE nor STX": (
        "STX wurde mit NAK oder einem Zeichen beantwortet, das weder DLE noch STX ist"
    ),
    "STX was not answered within QVZ/ADT": "STX wurde nicht innerhalb der QVZ/ADT beantwortet",
    "the partner broke off: a character came while the block was sent": (
        "der Partner brach ab: ein Zeichen kam, waehrend der Block gesendet wurde"
    ),
    "the block was answered with NAK or a character other than DLE": "der Block wurde mit NAK oder einem anderen Zeichen beantwortet",
    "the block was not answered within QVZ/ADT": "der Block wurde nicht innerhalb der QVZ/ADT beantwortet",
    "no connection: all connection attempts used up": "keine Verbindung: alle Verbindungsversuche verbraucht",
    "not sent: all block attempts used up": "nicht gesendet: alle Blockversuche verbraucht",
    "conflict that cannot be settled: both stations have priority high": "Konflikt nicht loesbar: beide Stationen haben hohe Prioritaet",
    "conflict that cannot be settled: both stations have priority low": "Konflikt nicht loesbar: beide Stationen haben niedrige Prioritaet",
    "a character other than NAK or STX came in idle, or characters after STX before DLE; normal when the partner is switched on": (
        "in Ruhe kam ein anderes Zeichen als NAK oder STX, oder Zeichen nach STX vor DLE; normal, wenn der Partner eingeschaltet wird"
    ),
    "DLE was followed by neither DLE nor ETX": "auf DLE folgte weder DLE noch ETX",
    "ZVZ/CDT exceeded": "ZVZ/CDT ueberschritten",
    "block check (BCC) wrong": "Blockpruefzeichen (BCC) falsch",
    "no repeat within the block wait time (BWZ)": "keine Wiederholung innerhalb der Blockwartezeit (BWZ)",
    "parity, framing or overrun error": "Paritaets-, Rahmen- oder Ueberlauffehler",
    "BREAK: the line to the partner is open": "BREAK: die Leitung zum Partner ist offen",
    "the partner reports a wrong sequence; normal after a restart of either side": (
        "der Partner meldet falsche Reihenfolge; normal nach einem Neustart einer Seite"
    ),
    "the partner's block is locked by a coordination flag": "der Baustein des Partners ist durch einen Koordinierungsmerker gesperrt",
    "the partner says: byte 3 of the command wrong": "der Partner meldet: Byte 3 des Befehls falsch",
    "the partner says: byte 1 or 4 of the command wrong": "der Partner meldet: Byte 1 oder 4 des Befehls falsch",
    "the partner says: length wrong": "der Partner meldet: Laenge falsch",
    "the partner has not been restarted yet": "der Partner hat noch nicht neu gestartet",
    "reaction without a request, or in the wrong sequence; normal after a restart of either side": (
        "Reaktion ohne Anforderung oder in falscher Reihenfolge; normal nach einem Neustart einer Seite"
    ),
    "byte 1 of the reaction is neither 00 nor FF": "Byte 1 der Reaktion ist weder 00 noch FF",
    "the reaction has too much or too little data": "die Reaktion hat zu viele oder zu wenige Daten",
    "the reaction to a SEND has data": "die Reaktion auf ein SEND hat Daten",
    "no reaction within the monitoring time (BWZ)": "keine Reaktion innerhalb der Ueberwachungszeit (BWZ)",
}
GERMAN: Mapping[str, str] = {**VERDICTS, **LEVELS, **BENCH, **RECEIVE, **SEND, **RK512, **REPORT, **DIAGNOSIS, **S5, **CP341}
