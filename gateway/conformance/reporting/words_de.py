"""Labels of the report in German."""

GERMAN = {
    "Conformance report": "Konformitätsbericht",
    "page": "Seite",
    "of": "von",
    "Report number": "Berichtsnummer",
    "not stated: [device] of the bench": "nicht angegeben: [device] der Prüfumgebung",
    "Item tested": "Prüfgegenstand",
    "maker": "Hersteller",
    "type": "Typ",
    "serial number": "Seriennummer",
    "version": "Version",
    "firmware": "Firmware",
    "hardware": "Hardware",
    "Suite": "Prüffolge",
    "Result": "Ergebnis",
    "Findings": "Befunde",
    "No findings.": "Keine Befunde.",
    "Cases": "Prüffälle",
    "Case": "Prüffall",
    "Verdict": "Urteil",
    "Expected": "Erwartet",
    "Got": "Erhalten",
    "Reason": "Grund",
    "Times": "Zeiten",
    "Trace": "Mitschnitt",
    "Coverage of requirements": "Abdeckung der Anforderungen",
    "Requirement": "Anforderung",
    "Assumed": "Angenommen",
    "Self-check of the bench": "Selbstprüfung der Prüfumgebung",
    "Bench": "Prüfumgebung",
    "Port": "Schnittstelle",
    "Mutant score of the suite": "Wirksamkeit der Prüffolge",
    "{} of {} faulty devices are found by this suite": "{} von {} fehlerhaften Geräten findet diese Prüffolge",
    "Seed": "Startwert",
    "Versions": "Versionen",
    "Check sum": "Prüfsumme",
    "caused by": "verursacht durch",
    "waived": "mit Ausnahme",
    "waived by {} until {}: {}": "Ausnahme von {} bis {}: {}",
    "place": "Ort",
    "customer": "Auftraggeber",
    "date": "Datum",
    "method": "Verfahren",
    "deviations": "Abweichungen vom Verfahren",
    "uncertainty": "Messunsicherheit",
    "decision_rule": "Entscheidungsregel",
    "decision rule": "Entscheidungsregel",
    "person": "Prüfer",
    "laboratory": "Prüflabor",
    "number": "Nummer",
    "title": "Titel",
    "Laboratory": "Angaben des Prüflabors",
    "Signature": "Unterschrift",
    "Further findings are on the next page.": "Weitere Befunde stehen auf der nächsten Seite.",
    "Nothing was stated.": "Nichts angegeben.",
    "clock": "Uhr",
    "virtual": "virtuell",
    "monotonic clock of this host, at the port": "monotone Uhr des Prüfrechners, an der Schnittstelle",
    "echo": "Echo",
    "False": "nein",
    "True": "ja",
    "None": "-",
    "latency_ms": "Latenz in ms",
    "jitter_ms": "Jitter in ms",
    "character_ms": "Dauer eines Zeichens in ms",
    "interrupted": "abgebrochen",
    "The run was interrupted; what was done is reported.": "Der Lauf wurde abgebrochen; das Erledigte ist aufgeführt.",
    "host late at most": "Prüfrechner höchstens verspätet um",
    "remark": "Bemerkung",
    "not run: the preamble needs {}, which is {} ({})": "nicht ausgeführt: der vorausgesetzte Prüffall {} ist {} ({})",
    "took": "Dauer",
    "role": "Rolle",
    "clause": "Fundstelle",
    "Sources of the clauses": "Quellen der Fundstellen",
    "summary of the manuals by axisgate; 3964(R): 1.1 characters, 1.2 block check, 1.3 sender, 1.4 receiver, 1.5 times, 1.6 "
    "priority; RK512: 2.1 command, 2.2 reaction, 2.3 follow-on telegrams, 2.4 error numbers, 2.5 coordination flag, 2.6 order "
    "of jobs. Manuals: Siemens CP 340 (A5E00369892), CP 341 (A5E02191071), CP 440 (A5E00057742); Bosch R500 computer "
    "interface (1070 072 131-102); VIPA CP 240 (HB97E-CP)": (
        "Zusammenfassung der Handbücher durch axisgate; 3964(R): 1.1 Zeichen, 1.2 Blockprüfung, 1.3 Sender, 1.4 Empfänger, 1.5 "
        "Zeiten, 1.6 Priorität; RK512: 2.1 Befehl, 2.2 Reaktion, 2.3 Folgetelegramme, 2.4 Fehlernummern, 2.5 "
        "Koordinierungsmerker, 2.6 Reihenfolge der Aufträge. Handbücher: Siemens CP 340 (A5E00369892), CP 341 (A5E02191071), CP "
        "440 (A5E00057742); Bosch R500 Rechnerkopplung (1070 072 131-102); VIPA CP 240 (HB97E-CP)"
    ),
    "decision of axisgate, in its documentation (docs/decisions.md)": "Entscheidung von axisgate, in dessen Dokumentation "
    "(docs/decisions.md)",
    "This report states how the tested item behaved in the listed tests on the listed bench. It is not a certificate and not a conformity "
    "test of CAN in Automation, the Modbus Organization or any manufacturer. Results relate only to the item tested.": "Dieser Bericht "
    "gibt wieder, wie sich der Prüfgegenstand in den aufgeführten Prüfungen an der aufgeführten Prüfumgebung verhielt. Er ist kein "
    "Zertifikat und keine Konformitätsprüfung von CAN in Automation, der Modbus Organization oder eines Herstellers. Die Ergebnisse "
    "beziehen sich nur auf den Prüfgegenstand.",
    "A time FAILs only if its whole interval (uncertainty included) is outside the limit, PASSes if it is inside; else it is measured "
    "again, at most three times, and is INCONC.": "Eine Zeit ist FAIL nur, wenn ihr ganzes Intervall (samt Unsicherheit) außerhalb der "
    "Grenze liegt, PASS, wenn es innerhalb liegt; sonst wird sie höchstens dreimal gemessen und ist INCONC.",
}
