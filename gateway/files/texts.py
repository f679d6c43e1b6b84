"""The sentences of configs/texts, by file."""

import functools
import tomllib

from gateway.files.find import PACKAGED, read_text
from gateway.pure.reports.sentences import Texts
from gateway.pure.reports.spoken import Spoken


@functools.cache
def read_texts(name: str) -> Texts:
    """Id -> (English, German) of one file."""
    tables = tomllib.loads(read_text(PACKAGED / "texts" / f"{name}.toml"))
    return Texts({key: (table["text"][0], table["text"][1]) for key, table in tables.items()})


@functools.cache
def spoken(*names: str) -> Spoken:
    """A function that translates English sentences to German, by these files."""
    return Spoken([pair for name in names for pair in read_texts(name).pairs()])
