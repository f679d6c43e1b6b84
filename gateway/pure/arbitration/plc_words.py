"""What a PLC has written into the data blocks of its line, without forces, and which of it since the link began."""

from collections.abc import Mapping


class PlcWords:
    """Bytes of complete blocks, by number; 2 bytes a word."""

    def __init__(self, words: Mapping[int, int]) -> None:
        """`words`: size of each block."""
        self._said = {number: bytearray(2 * count) for number, count in words.items()}
        self._since = {number: bytearray(2 * count) for number, count in words.items()}  # 1: written since the link began

    def restart(self) -> None:
        """Start of services or return of the link."""
        for since in self._since.values():
            since[:] = bytes(len(since))

    def write(self, db: int, first: int, data: bytes) -> bytes:
        """Write from this byte on; return the complete block as the PLC now has it."""
        self._said[db][first : first + len(data)] = data
        self._since[db][first : first + len(data)] = b"\1" * len(data)
        return bytes(self._said[db])

    def whole(self, db: int) -> bytes:
        return bytes(self._said[db])

    def complete(self, db: int, first: int, size: int) -> bool:
        """All of these bytes were written since the link began."""
        return all(self._since[db][first : first + size])
