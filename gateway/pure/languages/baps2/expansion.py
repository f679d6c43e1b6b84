"""Puts included files in the place of their INCLUDE instructions."""

from gateway.pure.languages.baps2.lexer import Kind, Token, tokens_of
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position, SourceFile
from gateway.pure.languages.base.store import ProgramStore

MOST_INCLUDED = 16  # files nested
MOST_FILES = 500  # included in all: files that include others several times grow without end


def expanded(source: SourceFile, words: Words, store: ProgramStore, faults: Faults) -> tuple[list[Token], dict[str, list[str]]]:
    """The tokens of a program and its included files, and the rows of each file.  Files that are missing or include themselves are
    reported."""
    expansion = _Expansion(words, store, faults)
    expansion.expand(source)
    return expansion.tokens, expansion.rows


class _Expansion:
    def __init__(self, words: Words, store: ProgramStore, faults: Faults) -> None:
        self._words, self._store, self._faults = words, store, faults
        self.tokens: list[Token] = []
        self.rows: dict[str, list[str]] = {}
        self._files = 0  # included
        self._absent: set[str] = set()  # to be included

    def expand(self, source: SourceFile) -> None:
        """Adds the tokens of a file; an included file in the place of its instruction, without its END token."""
        self.rows[source.name] = source.text.splitlines()
        tokens = tokens_of(source, self._words, self._faults)
        first = 0
        for place, token in enumerate(tokens):
            if token.kind is Kind.INSTRUCTION:
                word, _, name = token.text.partition(";")[0].strip().partition(" ")
                if word.upper() == "INCLUDE":
                    self.tokens += tokens[first:place]
                    self._include(source, name.strip(" =:"), token.position)
                    first = place + 1
        self.tokens += tokens[first:]
        if source.included_from is not None:
            self.tokens.pop()

    def _include(self, source: SourceFile, name: str, at: Position) -> None:
        file = name.upper() if "." in name else f"{name.upper()}.QLL"
        text = self._store.text(file)
        if not name or text is None:
            if file not in self._absent:
                self._faults.error("include-missing", at, f"file {file} does not exist" if name else "INCLUDE names no file")
            self._absent.add(file)
        elif source.includes_itself(file):
            self._faults.error("include-loop", at, f"{file} includes itself")
        elif source.depth() >= MOST_INCLUDED:
            self._faults.error("include-too-deep", at, f"more than {MOST_INCLUDED} nested include files")
        elif self._files >= MOST_FILES:
            if self._files == MOST_FILES:
                self._faults.error("include-too-deep", at, f"more than {MOST_FILES} include files")
            self._files = MOST_FILES + 1
        else:
            self._files += 1
            self.expand(SourceFile(file, text, at))
