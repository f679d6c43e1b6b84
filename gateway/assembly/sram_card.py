"""The SRAM card of a rho 3.0: a file whose size is that of the card.  Source: rho 3 Releases L11424-11581; AX-1756.

The files stay in the folder of the memory; equal marks there and on the card show that they belong together.
"""

import os
import pathlib
import secrets

from gateway.assembly.eeprom import is_protected
from gateway.files.safe_file import write_whole

SMALLEST = 1 << 20  # bytes
MARK = ".sram-card"  # in the folder of the memory
HEAD = b"axisgate SRAM "
MARK_LENGTH = len(HEAD) + 16
NO_CARD, PROTECTED_CARD, TOO_SMALL_CARD, DEFECTIVE = "No SRAM-Card", "Write protection", "SRAM - Card too small", "PCMCIA - Card defective"


def card_refused(card: pathlib.Path) -> str:
    """Why it cannot be initialised; empty: it can."""
    try:
        found = (
            (not card.exists(), NO_CARD),
            (card.exists() and not card.is_file(), DEFECTIVE),
            (is_protected(card), PROTECTED_CARD),
            (card.exists() and card.stat().st_size < SMALLEST, TOO_SMALL_CARD),
        )
    except OSError:
        return DEFECTIVE
    return next((words for applies, words in found if applies), "")


def format_card(card: pathlib.Path, folder: pathlib.Path) -> None:
    """It belongs to this memory from now on.  OSError."""
    mark = HEAD + secrets.token_hex(8).encode()
    with card.open("r+b") as file:
        file.write(mark)
        file.flush()
        os.fsync(file.fileno())
    write_whole(folder / MARK, mark)


def without_card(folder: pathlib.Path) -> None:
    """The memory is the internal one again.  OSError."""
    (folder / MARK).unlink(missing_ok=True)


def in_use(folder: pathlib.Path) -> bool:
    """A card was initialised here."""
    return (folder / MARK).exists()


def in_place(card: pathlib.Path | None, folder: pathlib.Path) -> bool:
    """The card of this memory is inserted and writable."""
    if card is None or card_refused(card):
        return False
    try:
        with card.open("rb") as file:
            return file.read(MARK_LENGTH) == (folder / MARK).read_bytes()
    except OSError:
        return False
