"""The programs of the rho 3 manual: each is checked without errors and runs as recorded; repairs are noted in the vectors."""

import json
import pathlib
import tomllib

import pytest

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import feed_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
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


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.toml")))
def test_a_printed_program_runs_as_recorded(name: str) -> None:
    feed = feed_of(tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8")))
    store = memory(feed.compiled)
    machine = DryRun(Library(WORDS, store), store, feed)
    assert machine.run(name) is None
    recorded = [json.loads(line) for line in (FOLDER / f"{name}.trace").read_text(encoding="utf-8").splitlines()]
    assert [json.loads(json.dumps(event)) for event in machine.trace] == recorded
