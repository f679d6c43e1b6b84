"""Checks and runs BAPS2 sources in tests."""

import tomllib

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import feed_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from hil_tests.unit.languages.baps2.words import WORDS

Event = dict[str, object]


def library_of(files: dict[str, str]) -> Library:
    """Programs by name; other files with their extension."""
    return Library(WORDS, Memory({name if "." in name else f"{name}.QLL": text.encode() for name, text in files.items()}))


def faults_of(text: str, **others: str) -> list[tuple[str, int]]:
    """Kind and line of each fault of a checked program."""
    _, faults = library_of(others).check("P.QLL", text)
    return [(fault.id, fault.position.line) for fault in faults]


def run(text: str, feed: str = "", **others: str) -> list[Event]:
    """The events of program P, without the files at the end."""
    return all_of(text, feed, **others)[:-1]


def all_of(text: str, feed: str = "", **others: str) -> list[Event]:
    """All events of program P."""
    given = feed_of(tomllib.loads(feed))
    files = {name if "." in name else f"{name}.QLL": each.encode() for name, each in {"P": text, **others}.items()}
    memory = Memory(files, given.compiled)
    library = Library(WORDS, memory)
    unit, faults = library.unit("P")
    assert unit is not None, [str(fault) for fault in faults]
    machine = DryRun(library, memory, given)
    assert machine.run("P") is None
    return list(machine.trace)


def body(statements: str, declared: str = "") -> str:
    """A whole program."""
    return f"PROGRAM P\n{declared}\nBEGIN\n{statements}\nPROGRAM_END\n"


def written(events: list[Event]) -> list[str]:
    """What was written, as characters."""
    return [bytes.fromhex(str(event["hex"])).decode("cp437") for event in events if event["event"] == "write"]


def short(events: list[Event], *names: str) -> list[tuple[object, ...]]:
    """Moment and what happened, of the events named."""
    rows = []
    for event in events:
        if event["event"] in names:
            rows.append(
                (event["t"], event["event"], *(event[key] for key in ("n", "channel", "value", "met", "code", "how") if key in event))
            )
    return rows
