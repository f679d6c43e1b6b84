"""Keys of the pendant by their place, and what KEY.BNR of the user memory makes of them.  Source: rho 3 Releases L10344-10758; rho3 7.4.

A key is named K1 to K36 with the level in front: `K1`, `SHIFT+K26`, `ALT+K5`.  A faulty file is not used, and nothing is reported (L10358).
"""

import re

BYTES, KEYS = 256, 36
NORMAL, SHIFT, ALT, PIC = 0, 64, 128, 192
LEVELS = {"": NORMAL, "SHIFT+": SHIFT, "ALT+": ALT}
PIC_MODES = ("3.2.1", "6.1")
INDEX = (
    40, 41, 42, 43, 38, 39, 30, 31, 36, 37, 28, 29, 34, 35, 26, 27, 32, 33, 24, 25, 15, 16, 17, 18, 12, 13, 14, 19, 9, 10, 11, 20, 8, 21,
    22, 23,
)  # fmt: skip
STANDARD = {  # codes of K1 to K36
    NORMAL: "7472696b6d6673677170646a6c6e65687b206f3d3738392d3435360031323300302e100a",
    SHIFT: "4142434445464748494a4b4c4d4e4f507a07515253545556570f580018590e005a0c100a",
    ALT: "5f3b20203f2720205b5d202028292020082020203c3e06202b2a3a00212f2500402c100a",
    PIC: "1b75456b1c1a4167731d4d6a3d621f1e7b206f3d3738392d3435360031323300302e100a",
}
FIXED = (
    *((base, 0x5A) for base in (0, 64, 128, 192)),
    *((place, 0x20) for first, last in ((1, 7), (44, 63), (65, 71), (108, 127), (129, 135), (172, 191), (193, 199), (236, 255))
      for place in range(first, last + 1)),
)  # fmt: skip
NAMES = {
    0x0A: "ENTER", 0x10: "DELETE", 0x18: "LEFT", 0x0E: "RIGHT", 0x0F: "UP", 0x0C: "DOWN", 0x7B: "MODE", 0x7A: "INFO", 0x07: "KIN",
    0x08: "GROUP", 0x06: "6+", ord("t"): "MOVE", ord("r"): "LINEAR", ord("i"): "VIA", ord("k"): "TO", ord("m"): "WAIT", ord("f"): "UNTIL",
    ord("s"): "BEGIN", ord("g"): "END", ord("q"): "IF", ord("p"): "THEN", ord("d"): "ELSE", ord("j"): "JUMP", ord("l"): "RPT",
    ord("n"): "TIMES", ord("e"): "RPT_END", ord("h"): "HALT", ord("o"): "V_PTP", ord("b"): "JC", ord("u"): "AN",
}  # fmt: skip
SHIFT_KEY, ALT_KEY = 32, 28  # K32, K28
_PLACE = re.compile(r"(SHIFT\+|ALT\+|)K([1-9]|[12]\d|3[0-6])")


def standard() -> bytes:
    """The file as it would be for the standard assignment."""
    table = bytearray(b"\x20" * BYTES)
    for place, value in FIXED:
        table[place] = value
    for base, codes in STANDARD.items():
        for index, code in zip(INDEX, bytes.fromhex(codes), strict=True):
            table[base + index] = code
    return bytes(table)


class KeyTable:
    """The assignment that is used; read at a start of the control."""

    def __init__(self) -> None:
        self._table = standard()

    def load(self, data: bytes) -> bool:
        """KEY.BNR, b"" where there is none; False: it is faulty, and the standard assignment is used."""
        sound = len(data) == BYTES and all(data[place] == value for place, value in FIXED)
        self._table = data if sound else standard()
        return sound

    def named(self, key: str, mode: str = "") -> str | None:
        """Return the function of a key at its place; None: it has no effect.  A name other than a place is a key itself."""
        found = _PLACE.fullmatch(key)
        if found is None:
            return key
        level = LEVELS[found[1]]
        own = {SHIFT: SHIFT_KEY, ALT: ALT_KEY}.get(level)
        if own is not None and self._table[INDEX[own - 1]] != 0:
            return None  # that key has another effect, and its level is gone (L10379)
        if level == NORMAL and mode in PIC_MODES:
            level = PIC
        code = self._table[level + INDEX[int(found[2]) - 1]]
        return NAMES.get(code) or (chr(code) if 0x21 <= code <= 0x5F else None)
