"""Reads BAPS2 for tests: the shipped words, sources in memory."""

import pathlib
import tomllib

from gateway.pure.languages.baps2.reader import read
from gateway.pure.languages.baps2.tree import Program
from gateway.pure.languages.baps2.words import Words, words_of
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import SourceFile
from gateway.pure.languages.base.store import MemoryStore

FILE = next(parent for parent in pathlib.Path(__file__).resolve().parents if (parent / "configs").is_dir()) / "configs/languages/baps2.toml"
WORDS: Words = words_of(tomllib.loads(FILE.read_text(encoding="utf-8"))["words"])


def read_text(text: str, **files: str) -> tuple[Program | None, Faults]:
    """The tree and the faults; `files`: NAME="text" of files to include."""
    faults = Faults()
    store = MemoryStore({f"{name}.QLL": each for name, each in files.items()})
    return read(SourceFile("MAIN.QLL", text), WORDS, store, faults), faults


def ids_of(faults: Faults) -> list[tuple[str, int]]:
    """Kind and line of each fault."""
    return [(fault.id, fault.position.line) for fault in faults]
