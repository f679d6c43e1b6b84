"""German texts of `diagnose` and the report about a line; the other texts and the rules: texts_de."""

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
        "axisgate ist keine Sicherheitseinrichtung. Not-Halt, STO, Schutztueren, Zustimmeinrichtungen und sichere Geschwindigkeit sind in "
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
    "after 1 test: {}": "nach 1 Pruefung: {}",
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
    'set this side to priority = "low"': 'diese Seite auf priority = "low" setzen',
    'set this side to priority = "high"': 'diese Seite auf priority = "high" setzen',
    "priority": "Prioritaet",
    "the partner has priority {}, this side {}": "der Partner hat die Prioritaet {}, diese Seite {}",
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
    "blocks that the partner sent unprompted were acknowledged and not used: {}": (
        "Bloecke, die der Partner von selbst sandte, wurden quittiert und nicht verwendet: {}"
    ),
    "nothing; stop its program where the blocks must not get lost": (
        "nichts; sein Programm anhalten, wo die Bloecke nicht verloren gehen duerfen"
    ),
    "other characters": "andere Zeichen",
    "{} characters without a meaning were answered with others: {}": "auf {} Zeichen ohne Bedeutung kamen andere: {}",
    "another protocol or speed at the partner, or cross-talk on an open line": (
        "anderes Protokoll oder andere Geschwindigkeit beim Partner, oder Uebersprechen auf einer offenen Leitung"
    ),
    "reaction spoilt": "Reaktion fehlerhaft",
    "the reaction to a FETCH is no good block: {}": "die Reaktion auf ein FETCH ist kein guter Block: {}",
    "parity, speed, or the partner's software": "Paritaet, Geschwindigkeit oder die Software des Partners",
    "{} characters were received while this side was silent": "{} Zeichen kamen, waehrend wir schwiegen",
    "is a third station on the line, or does the partner send unprompted?": (
        "ist eine dritte Station an der Leitung, oder sendet der Partner von selbst?"
    ),
    "echo": "Echo",
    "every character is returned ({} of {}): an echo": "jedes Zeichen kommt zurueck ({} von {}): ein Echo",
    "switch the echo of the 2-wire adapter off, or remove the loop-back plug; 3964R needs both directions apart": (
        "das Echo des 2-Draht-Wandlers abschalten oder den Pruefstecker ziehen; 3964R braucht getrennte Richtungen"
    ),
    "cross-talk": "Uebersprechen",
    "of {} characters {} were returned correctly and {} damaged: cross-talk on an open line, not an echo": (
        "von {} Zeichen kamen {} richtig und {} verstuemmelt zurueck: Uebersprechen auf einer offenen Leitung, kein Echo"
    ),
    "the receiving pair is open: partner off, plug out, wire broken, or TTY loop without current": (
        "das Empfangspaar ist offen: Partner aus, Stecker gezogen, Ader gebrochen, oder TTY-Schleife ohne Strom"
    ),
    "something answers, but no DLE: {}": "es antwortet etwas, aber kein DLE: {}",
    "not ready": "nicht bereit",
    "STX is answered with NAK: the partner is present but accepts no block": (
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
    "slow answers": "langsame Antworten",
    "answers take {:.0f} ms: the partner polls its line": (
        "Antworten brauchen {:.0f} ms: der Partner sieht nur in Schritten nach seiner Leitung"
    ),
    "nothing, while they stay far below QVZ/ADT": "nichts, solange sie weit unter der QVZ bleiben",
    "the latency timer of the USB adapter is set to {} ms: each answer can wait that long in the adapter": (
        "die Latenzzeit des USB-Wandlers steht auf {} ms: jede Antwort wartet bis zu so lange im Wandler"
    ),
    "answers take {:.0f} ms, as through a USB adapter whose latency timer is set to 16 ms": (
        "Antworten brauchen {:.0f} ms, wie durch einen USB-Wandler, dessen Latenzzeit auf 16 ms steht"
    ),
    "set the adapter's latency timer to 1 ms (Linux: latency_timer in sysfs; Windows: port settings)": (
        "die Latenzzeit des Wandlers auf 1 ms stellen (Linux: latency_timer in sysfs; Windows: Anschlusseinstellungen)"
    ),
    "echo {} | sudo tee {}": "echo {} | sudo tee {}",
    "3964 without R": "3964 ohne R",
    "{}: the partner is set to 3964": "{}: der Partner steht auf 3964",
    "blocks without check are taken, with check refused": "Bloecke ohne Pruefzeichen werden angenommen, mit Pruefzeichen abgelehnt",
    "blocks are taken without their check": "Bloecke werden ohne ihr Pruefzeichen angenommen",
    'set both to 3964R (or protocol = "3964")': 'beide auf 3964R stellen (oder protocol = "3964")',
    "blocks refused": "Bloecke abgelehnt",
    "a good block is refused with every check tried": "ein guter Block wird mit jedem versuchten Pruefzeichen abgelehnt",
    "parity, or another block format": "Paritaet, oder ein anderes Blockformat",
    "RK512 runs on 3964R{}": "RK512 laeuft auf 3964R{}",
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
    "the partner aborted: a character was received while the block was sent": (
        "der Partner brach ab: ein Zeichen kam, waehrend der Block gesendet wurde"
    ),
    "the block was answered with NAK or a character other than DLE": "der Block wurde mit NAK oder einem anderen Zeichen beantwortet",
    "the block was not answered within QVZ/ADT": "der Block wurde nicht innerhalb der QVZ/ADT beantwortet",
    "no connection: all connection attempts used up": "keine Verbindung: alle Verbindungsversuche verbraucht",
    "not sent: all block attempts used up": "nicht gesendet: alle Blockversuche verbraucht",
    "conflict that cannot be settled: both stations have priority high": "Konflikt nicht loesbar: beide Stationen haben hohe Prioritaet",
    "conflict that cannot be settled: both stations have priority low": "Konflikt nicht loesbar: beide Stationen haben niedrige Prioritaet",
    "a character other than NAK or STX was received in idle, or characters after STX before DLE; normal when the partner is switched on": (
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
    "the partner reports: byte 3 of the command wrong": "der Partner meldet: Byte 3 des Befehls falsch",
    "the partner reports: byte 1 or 4 of the command wrong": "der Partner meldet: Byte 1 oder 4 des Befehls falsch",
    "the partner reports: length wrong": "der Partner meldet: Laenge falsch",
    "the partner has not been restarted yet": "der Partner hat noch nicht neu gestartet",
    "reaction without a request, or in the wrong sequence; normal after a restart of either side": (
        "Reaktion ohne Anforderung oder in falscher Reihenfolge; normal nach einem Neustart einer Seite"
    ),
    "byte 1 of the reaction is neither 00 nor FF": "Byte 1 der Reaktion ist weder 00 noch FF",
    "the reaction has too much or too little data": "die Reaktion hat zu viele oder zu wenige Daten",
    "the reaction to a SEND has data": "die Reaktion auf ein SEND hat Daten",
    "no reaction within the monitoring time (BWZ)": "keine Reaktion innerhalb der Ueberwachungszeit (BWZ)",
}
