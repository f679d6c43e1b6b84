"""All faults of a source are collected, once each, in the order of the text."""

from gateway.pure.languages.base.faults import Faults, Severity
from gateway.pure.languages.base.source import Position, SourceFile


def test_faults_come_in_the_order_of_the_text_and_once_each() -> None:
    faults = Faults()
    faults.error("unknown-name", Position("A", 7, 2), "X is unknown", "declare it")
    faults.warning("long-name", Position("A", 3, 1), "name of 13 characters")
    faults.error("unknown-name", Position("A", 7, 2), "X is unknown")
    assert [(fault.position.line, fault.severity) for fault in faults] == [(3, Severity.WARNING), (7, Severity.ERROR)]
    assert faults.rows()[1] == {
        "file": "A",
        "line": 7,
        "column": 2,
        "severity": "error",
        "id": "unknown-name",
        "text": "X is unknown; declare it",
    }


def test_collecting_ends_at_the_number_of_errors_asked_for() -> None:
    faults = Faults(most=2)
    for line in range(5):
        faults.error("e", Position("A", line + 1), "wrong")
    assert (faults.errors, faults.full) == (2, True)


def test_suppressed_warnings_are_dropped() -> None:
    faults = Faults(warnings=False)
    faults.warning("w", Position("A", 1), "odd")
    assert len(faults) == 0


def test_an_included_file_knows_its_way_and_does_not_include_itself() -> None:
    main = SourceFile("MAIN", "")
    part = SourceFile("PART", "", main.at(4))
    assert [str(place) for place in part.at(2, 5).stack()] == ["PART:2:5", "MAIN:4:1"]
    assert part.includes_itself("MAIN")
    assert part.includes_itself("PART")
    assert not part.includes_itself("OTHER")
    assert part.depth() == 1
