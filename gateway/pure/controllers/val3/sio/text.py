"""Strings and numbers as bytes.  Source: VAL 3 manual, 3.7.2; the string type: 3.4 (UTF-8, at most 128 bytes)."""

import math

from gateway.pure.controllers.val3.sio.errors import Rte, Val3Error

MAX_STRING = 128  # bytes a VAL 3 string holds


def encode_text(text: str, end_of_string: int) -> bytes:
    """UTF-8 and the end character.  Raises Val3Error 70 on what no VAL 3 string can hold."""
    try:
        data = text.encode()
    except UnicodeEncodeError as error:
        raise Val3Error(Rte.BAD_VALUE, f"{text!r} has no UTF-8 form") from error
    if len(data) > MAX_STRING:
        raise Val3Error(Rte.BAD_VALUE, f"a string of {len(data)} bytes, at most {MAX_STRING} fit")
    return data + bytes((end_of_string,))


def nearest_byte(value: float) -> int:
    """Nearest integer modulo 256: 256.4 -> 0, -1 -> 255; halves go up (AX-185).  Raise Val3Error 70 for anything but a number."""
    if not math.isfinite(value):
        raise Val3Error(Rte.BAD_VALUE, f"{value} has no nearest integer")
    return math.floor(value + 0.5) % 256


def char_size(lead: int) -> int:
    """Bytes of the UTF-8 character that begins with `lead`; 0: none begins so."""
    if lead < 0x80:
        return 1
    for size, low, high in ((2, 0xC2, 0xDF), (3, 0xE0, 0xEF), (4, 0xF0, 0xF4)):
        if low <= lead <= high:
            return size
    return 0


class TextScan:
    """Reads one string out of a growing buffer without consuming it; continues where it stopped."""

    def __init__(self, end_of_string: int) -> None:
        self.end_of_string = end_of_string
        self.text = bytearray()  # good characters so far
        self.used = 0  # bytes of the buffer that belong to the string, its end character included
        self.done = False

    def run(self, data: bytearray) -> bool:
        """Return whether the string is complete: end character seen, or the next character would not fit."""
        while not self.done and self.used < len(data):
            if data[self.used] == self.end_of_string:
                self.used, self.done = self.used + 1, True
            elif not self._character(data):
                break
        return self.done

    def _character(self, data: bytearray) -> bool:
        """Takes or skips one character; False when its rest has not come."""
        start, size = self.used, char_size(data[self.used])
        stop = start + 1
        while stop < start + size and stop < len(data) and 0x80 <= data[stop] <= 0xBF and data[stop] != self.end_of_string:
            stop += 1
        if stop < start + size and stop == len(data):
            return False
        if stop != start + size or not _is_character(data[start:stop]):
            self.used = start + 1 if stop == start + size else stop  # not compatible: passed over
        elif len(self.text) + size > MAX_STRING:
            self.done = True  # stays complete for the next string
        else:
            self.text += data[start:stop]
            self.used, self.done = stop, len(self.text) == MAX_STRING
        return True


def _is_character(data: bytearray) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True
