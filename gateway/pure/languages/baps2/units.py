"""Devices of a dry run: received data is read piece by piece, in the form of the protocol."""

from dataclasses import dataclass, field

from gateway.pure.languages.baps2 import forms
from gateway.pure.languages.baps2.feed import UnitFeed

P3964R = 8


class Incomplete(Exception):
    """The rest has not come yet."""


@dataclass(slots=True)
class Device:
    """One unit.  `pieces`: received, unread data, block by block."""

    feed: UnitFeed
    pieces: list[bytearray] = field(default_factory=list)
    _next: int = 0

    @property
    def binary(self) -> bool:
        """Whether values are bytes, not characters."""
        return self.feed.protocol == P3964R

    def take_in(self, now: int) -> None:
        """What has come by now."""
        while self._next < len(self.feed.incoming) and self.feed.incoming[self._next][0] <= now:
            self.pieces.append(bytearray(self.feed.incoming[self._next][1]))
            self._next += 1

    @property
    def due(self) -> int | None:
        """When more comes."""
        return self.feed.incoming[self._next][0] if self._next < len(self.feed.incoming) else None

    def clear(self) -> None:
        """READ_BEGIN: drop the received data."""
        self.pieces.clear()

    def read(self, base: str, size: int, count: int) -> object:
        """One value, or the elements of an array.  Incomplete, BadForm."""
        if count and not self.binary and base == "CHAR":
            return self._letters(count)
        kept = [bytearray(piece) for piece in self.pieces]
        try:
            return [self._one(base, size) for _ in range(count)] if count else self._one(base, size)
        except Incomplete:
            self.pieces[:] = kept
            raise

    def _letters(self, count: int) -> list[str]:
        """Read an array of characters: up to the line end, filled with blanks."""
        value = str(self._one("TEXT", 0))
        return list(value[:count].ljust(count))

    def _one(self, base: str, size: int) -> object:
        while self.pieces and not self.pieces[0]:
            self.pieces.pop(0)
        if not self.pieces:
            raise Incomplete
        piece = self.pieces[0]
        if self.binary:
            need = forms.bytes_of(base, size, False)
            data = bytes(piece[:need])
            del piece[:need]
            if len(data) < need:
                raise forms.BadForm(-9)  # a block ends inside of a value (L1983)
            return forms.decode_binary(base, size, data, False)
        try:
            value, taken = forms.decode_letters(base, size, bytes(piece))
        except forms.BadForm:
            piece.clear()
            raise
        del piece[:taken]
        return value
