"""Reads the statements about devices and files: READ, WRITE, READ_BEGIN, WRITE_BEGIN, WRITE_END, CLOSE, ASSIGN."""

from collections.abc import Callable, Mapping
from functools import partial

from gateway.pure.languages.baps2.declarations import DeclarationReader
from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind
from gateway.pure.languages.baps2.mistakes import Mistakes
from gateway.pure.languages.baps2.standard import DEVICES
from gateway.pure.languages.baps2.stream import Stream
from gateway.pure.languages.baps2.tree import FileOrder, Read, Statement, Write
from gateway.pure.languages.base.source import Position


class OrderReader:
    """`called` receives the name of a file or a device."""

    def __init__(
        self,
        stream: Stream,
        expressions: ExpressionReader,
        declarations: DeclarationReader,
        mistakes: Mistakes,
        called: Callable[[], str],
    ) -> None:
        self._stream, self._expressions, self._declarations = stream, expressions, declarations
        self._mistakes, self._called = mistakes, called

    def readers(self) -> Mapping[str, Callable[[Position], Statement]]:
        """What reads a statement, by its first word."""
        files = {word: partial(self._file, word=word) for word in ("READ_BEGIN", "WRITE_BEGIN", "WRITE_END", "CLOSE")}
        return {"READ": self._read, "WRITE": self._write, **files, "ASSIGN": self._assign}

    def _device(self) -> str:
        """Read a device or file and the comma after it."""
        token, following = self._stream.token, self._stream.ahead()
        known = token.key in DEVICES or token.key in self._declarations.files
        if token.kind is Kind.NAME and known and following.text == ",":
            self._stream.take()
            self._stream.take()
            return token.key
        return self._mistakes.device()

    def _read(self, at: Position) -> Read:
        device = self._device()
        targets = [self._expressions.target()]
        while self._stream.comma():
            targets.append(self._expressions.target())
        return Read(at, device, tuple(targets))

    def _write(self, at: Position) -> Write:
        device, values, is_open = self._device(), [], False
        while True:
            if self._stream.sign(".."):
                is_open = True
                break
            values.append(self._expressions.read())
            if not self._stream.comma():
                is_open = self._stream.sign("..")
                break
        return Write(at, device, tuple(values), is_open)

    def _file(self, at: Position, word: str) -> FileOrder:
        bracket = self._stream.sign("(")  # READ_BEGIN (DATA), L2262
        file = self._called()
        if bracket:
            self._stream.expect_sign(")", "after the file")
        offset = self._expressions.sum() if word in ("READ_BEGIN", "WRITE_BEGIN") and self._stream.sign(",") else None
        return FileOrder(at, word, file, offset)

    def _assign(self, at: Position) -> FileOrder:
        file = self._called()
        self._stream.expect_sign(",", "after the file")
        return FileOrder(at, "ASSIGN", file, self._expressions.sum())
