"""The record of a run with --matrix: the result of each marked test, and the tree it belongs to."""

import hashlib
import json
import pathlib
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from hil_tests.matrix.catalogue import ROOT

FOLDERS = ("gateway", "drivers", "protocols", "motion", "hil_tests", "configs", "docs/requirements")
MADE = ("__pycache__", ".so", ".pyc")  # what runs leave in them


@dataclass(frozen=True, slots=True)
class Result:
    """One test function with its claim and the worst outcome of its parameters: passed, failed, skipped."""

    test: str
    ids: tuple[str, ...]
    by: tuple[str, ...]
    outcome: str


@dataclass(frozen=True, slots=True)
class Record:
    """A run."""

    tree: str  # fingerprint of all files it could have run
    at: str  # when it ended, local time
    whole: bool  # it was of all marked tests, and ran to its end, well or not
    results: tuple[Result, ...]


def tree() -> str:
    """Fingerprint of the sources, tests, shipped files and demands of the present tree."""
    seen = hashlib.sha256()
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()):
        if path.suffix not in MADE and not any(part in MADE for part in path.parts):
            seen.update(str(path.relative_to(ROOT)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return seen.hexdigest()[:16]


def save(path: pathlib.Path, of_tree: str, whole: bool, results: Sequence[Result]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    record = Record(of_tree, time.strftime("%Y-%m-%d %H:%M"), whole, tuple(results))
    path.write_text(json.dumps(asdict(record), indent=1))


def load(path: pathlib.Path) -> Record | None:
    """None: there is none, or none that can be read."""
    try:
        data = json.loads(path.read_text())
        results = tuple(Result(line["test"], tuple(line["ids"]), tuple(line["by"]), line["outcome"]) for line in data["results"])
        return Record(data["tree"], data["at"], data["whole"], results)
    except (OSError, ValueError, KeyError, TypeError):
        return None
