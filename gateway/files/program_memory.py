"""The folder that is the user memory of an old controller, and the word table of its language: the only place they are read."""

import pathlib
import tomllib

from gateway.files.find import find_config, read_text
from gateway.pure.languages.baps2.feed import Feed, FeedFault, feed_of
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.words import Words, words_of

SUFFIXES = (".QLL", ".PKT", ".SYM", ".ERR", ".DAT", ".BNR", ".QLS", ".IRD")
MOST_OCTETS = 4 << 20  # of one file: the greatest memory card (L11031-11035)


def baps2_words() -> Words:
    """The shipped words."""
    return words_of(tomllib.loads(read_text(find_config("baps2.toml", "languages")))["words"])


def folder_memory(folder: pathlib.Path, feed: Feed | None = None) -> Memory:
    """All files of a memory folder.  OSError: it cannot be read."""
    files = {
        path.name.upper(): path.read_bytes()
        for path in sorted(folder.iterdir())
        if path.is_file() and path.suffix.upper() in SUFFIXES and path.stat().st_size <= MOST_OCTETS
    }
    return Memory(files, feed.compiled if feed else ())


def read_feed(path: pathlib.Path) -> Feed:
    """A feed file.  FeedFault: one sentence; OSError."""
    try:
        return feed_of(tomllib.loads(read_text(path)))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FeedFault(f"no TOML: {error}") from error
