"""MSD.DAT, TEXT.DAT, EXPROG.DAT and PHGCODE.DAT as tables.  Source: rho 3 Releases L839-853, L900-935, L2655-2667, L4937-5005."""

import re

from gateway.pure.controllers.rho3.functions.dat_lines import LineError, Table, head_of, only_comment, parse, quoted, tail_of

_DECIMAL = re.compile(r"[0-9]{2}")
_HEX_UPPER = re.compile(r"[0-9A-F]{2}")
_HEX = re.compile(r"[0-9A-Fa-f]{2}")
_DIGIT = re.compile(r"[0-9A-Fa-f]")
_CHANNEL = re.compile(r"([^'; \t,]*)[ \t]*(,?)[ \t]*")
_NAME = re.compile(r"[A-Za-z0-9_]{1,8}(?=[ \t;]|$)")  # names have up to 8 characters incl. _ (L649-672)
_MODE = re.compile(r"[0-9]+(?:\.[0-9]+)*(?=[ \t;]|$)")


def parse_msd(text: str, file: str = "MSD.DAT") -> Table[str]:
    """Number of a status 1..99 -> text."""
    return parse(file, text, _msd_line)


def parse_texts(text: str, file: str = "TEXT.DAT") -> Table[str]:
    """Code 0..255 -> text; the channel is PHG, stated or not."""
    return parse(file, text, _text_line)


def parse_exprog(text: str, file: str = "EXPROG.DAT") -> Table[str]:
    """Code 0..255 -> name of a program in upper case."""
    return parse(file, text, _exprog_line)


def parse_phgcode(text: str, file: str = "PHGCODE.DAT") -> Table[str]:
    """Code 0..15 -> mode of the panel."""
    return parse(file, text, _phgcode_line)


def _msd_line(line: str) -> tuple[int, str]:
    head = head_of(line)
    if not _DECIMAL.fullmatch(head) or head == "00":
        raise LineError("two_decimal", head)
    return int(head), quoted(tail_of(line))


def _text_line(line: str) -> tuple[int, str]:
    head = head_of(line)
    if not _HEX_UPPER.fullmatch(head):
        raise LineError("two_hex_upper", head)
    tail = tail_of(line)
    found = _CHANNEL.match(tail)
    channel, comma = (found[1], found[2]) if found else ("", "")
    if (channel or comma) and channel != "PHG":
        raise LineError("channel", channel)
    if channel and not comma:
        raise LineError("comma")
    return int(head, 16), quoted(tail[found.end() :] if found else tail)


def _exprog_line(line: str) -> tuple[int, str]:
    head, tail = head_of(line), tail_of(line)
    if not _HEX.fullmatch(head):
        raise LineError("two_hex", head)
    found = _NAME.match(tail)
    if found is None:
        raise LineError("name", tail.partition(";")[0].rstrip(" \t"))
    only_comment(tail[found.end() :])
    return int(head, 16), found[0].upper()


def _phgcode_line(line: str) -> tuple[int, str]:
    head, tail = head_of(line), tail_of(line)
    if not _DIGIT.fullmatch(head):
        raise LineError("one_hex", head)
    found = _MODE.match(tail)
    if found is None:
        raise LineError("mode", tail.partition(";")[0].rstrip(" \t"))
    only_comment(tail[found.end() :])
    return int(head, 16), found[0]
