"""Forced RC inputs and data words: an overlay with its own mark over what the command sources write (design: section 5; AX-472, AX-498).

A force exists in the services only: it ends with them, and nothing forced survives a restart.  The five enabling inputs are forced in a
simulation only.
"""

from gateway.pure.image.records.cell import RC_BYTES, InputImage, Quality, set_bit
from protocols.base.machine import Ns

MOST = 256  # forces of each kind at once
Place = tuple[int, int]  # line_blocks.block_key, word


class Forces:
    """RC input bit -> value kept whatever its command source writes; data word -> mask of forced bits and their values."""

    def __init__(self) -> None:
        self.bits: dict[int, bool] = {}
        self.words: dict[Place, tuple[int, int]] = {}
        self._stamp: Ns = 0

    def put(self, number: int, value: bool, now: Ns) -> None:
        """ValueError: no such bit, or too many."""
        if not 0 <= number < 8 * RC_BYTES:
            raise ValueError(f"RC input {number}: 0..{8 * RC_BYTES - 1}")
        if len(self.bits) >= MOST and number not in self.bits:
            raise ValueError(f"{MOST} inputs are forced already")
        self.bits[number] = value
        self._stamp = now

    def drop(self, number: int | None = None) -> None:
        """One, or all of them."""
        if number is None:
            self.bits.clear()
        else:
            self.bits.pop(number, None)

    @property
    def count(self) -> int:
        """Everything that is forced."""
        return len(self.bits) + len(self.words)

    def put_word(self, place: Place, mask: int, value: int) -> None:
        """Force the bits of the mask, in addition to those already forced; ValueError: too many."""
        if len(self.words) >= MOST and place not in self.words:
            raise ValueError(f"{MOST} words are forced already")
        old_mask, old = self.words.get(place, (0, 0))
        self.words[place] = (old_mask | mask, (old & ~mask) | (value & mask))

    def drop_word(self, place: Place, mask: int = 0xFFFF) -> None:
        """The bits of the mask."""
        old_mask, old = self.words.pop(place, (0, 0))
        if old_mask & ~mask:
            self.words[place] = (old_mask & ~mask, old & ~mask)

    def over(self, image: InputImage) -> InputImage:
        """The image with the forces applied; the image itself if nothing is forced.

        A byte without a writer becomes good with its other bits at 0: bits not forced there are not allowed.
        """
        if not self.bits:
            return image
        laid = InputImage(bytearray(image.values), bytearray(image.quality), list(image.stamps))
        for octet in {number >> 3 for number in self.bits}:
            if laid.quality[octet] != Quality.GOOD:
                laid.values[octet], laid.quality[octet], laid.stamps[octet] = 0, Quality.GOOD, self._stamp
        for number, value in self.bits.items():
            set_bit(laid.values, number, value)
        return laid
