"""The programs of the rho 3 manual: each is checked without errors and runs as recorded; repairs are noted in the vectors."""

import json
import pathlib
import re
import tomllib

import pytest

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import feed_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.base.faults import Severity
from hil_tests.unit.languages.baps2.words import WORDS

FOLDER = next(parent for parent in pathlib.Path(__file__).resolve().parents if parent.name == "hil_tests") / "vectors/baps2"
INCLUDED = ("HEADER", "HEAD_PAINT")
PROGRAMS = sorted(path.stem for path in FOLDER.glob("*.QLL") if path.stem not in INCLUDED)
WARNED = ("ASYN_IN", "BELTYP2", "L_BNR", "L_CURVE", "MOVEFILE", "RCMASTER", "RCSLAVE")  # names of more than 12 characters


def memory(compiled: tuple[str, ...] = ()) -> Memory:
    return Memory({path.name: path.read_bytes() for path in FOLDER.glob("*.QLL")}, compiled)


def test_all_programs_are_there() -> None:
    assert len(PROGRAMS) == 35
    assert [name for name in PROGRAMS if not (FOLDER / f"{name}.trace").exists()] == [], "each runs as recorded, too"


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_printed_program_has_no_errors(name: str) -> None:
    unit, faults = Library(WORDS, memory()).unit(name)
    assert unit is not None
    assert {fault.id for fault in faults} <= ({"long-name"} if name in WARNED else set())


def test_a_misspelt_word_of_a_declaration_is_one_fault() -> None:
    """What it declares may be anything: its uses are no further faults."""
    word = re.compile(r"\b(INTEGER|REAL|BINARY|(?:JC_)?POINT|INPUT|OUTPUT|(?:BNR_)?FILE|SEMAPHORE|SPC_FCT|ARRAY|CONST|TEXT|BELT|VALUE)\b")
    tried: set[tuple[str, str]] = set()
    for name in PROGRAMS:
        text = (FOLDER / f"{name}.QLL").read_text(encoding="utf-8")
        for found in word.finditer(text):
            if (name, found.group()) not in tried:
                tried.add((name, found.group()))
                _, faults = Library(WORDS, memory()).check(
                    f"{name}.QLL", f"{text[: found.start()]}{found.group()[:2]}{text[found.start() + 3 :]}"
                )
                assert sum(fault.severity is Severity.ERROR for fault in faults) <= 1, (name, found, [str(fault) for fault in faults])
    assert len(tried) > 60


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.toml")))
def test_a_printed_program_runs_as_recorded(name: str) -> None:
    feed = feed_of(tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8")))
    store = memory(feed.compiled)
    machine = DryRun(Library(WORDS, store), store, feed)
    assert machine.run(name) is None
    recorded = [json.loads(line) for line in (FOLDER / f"{name}.trace").read_text(encoding="utf-8").splitlines()]
    assert [json.loads(json.dumps(event)) for event in machine.trace] == recorded
