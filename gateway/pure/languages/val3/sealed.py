"""Encrypted libraries: ZIP files with the classic encryption, and the coding of their passwords.  Source: VAL 3 reference 6.5, L3910-3925.

The coding of the tool of the maker is not known: this one is our own (AX-992).  It hides the ZIP password, it does not protect it.
"""

import binascii
import struct
import zlib
from collections.abc import Iterator

from gateway.pure.languages.val3.disk import Disk, PathFault, application_of

LONGEST_NAME = 14  # with .zip
SHORTEST_SECRET = 11
LARGEST = 16 << 20  # bytes of all files of a library
KEY = b"axisgate val3 library"
END, ENTRY, LOCAL = b"PK\x05\x06", b"PK\x01\x02", b"PK\x03\x04"
ENCRYPTED, STRONG = 0x0001, 0x0040
STORED, DEFLATED = 0, 8


class SealFault(Exception):
    """`code`: what libLoad returns, 12 or 23."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


# ---- passwords ----------------------------------------------------------------------------------------------------------------


def _stream(length: int, seed: int) -> Iterator[int]:
    state = zlib.crc32(KEY, seed)
    for _ in range(length):
        state = zlib.crc32(state.to_bytes(4, "big"), seed)
        yield state & 0xFF


def public_of(secret: str) -> str:
    """The VAL 3 password of a ZIP password."""
    data = secret.encode()
    seed = zlib.crc32(data)
    mixed = bytes(byte ^ key for byte, key in zip(data, _stream(len(data), seed), strict=True))
    return (seed.to_bytes(4, "big") + mixed).hex()


def secret_of(public: str) -> str | None:
    """Return the ZIP password; None: the text is not a VAL 3 password."""
    try:
        raw = binascii.unhexlify(public.strip())
    except (ValueError, binascii.Error):
        return None
    seed, mixed = int.from_bytes(raw[:4], "big"), raw[4:]
    data = bytes(byte ^ key for byte, key in zip(mixed, _stream(len(mixed), seed), strict=True))
    if len(raw) < 5 or zlib.crc32(data) != seed:
        return None
    try:
        return data.decode()
    except UnicodeDecodeError:
        return None


def library_of(disk: Disk, path: str, current: str, password: str | None = None) -> tuple[str, str]:
    """Folder and name of a library; an encrypted one is opened.  PathFault, SealFault."""
    folder, name = application_of(path, current)
    if not path.lower().endswith(".zip"):
        if password:
            raise SealFault(23, "a password belongs to a library with .zip")
        return folder, name
    if len(name) > LONGEST_NAME:
        raise PathFault(22, f"{name}: {LONGEST_NAME} characters with .zip are the most")
    data = disk.read(folder)
    if data is None:
        raise PathFault(39, "there is no such file")
    secret = None if password is None else secret_of(password)
    if secret is None:
        raise SealFault(12, "the password is none that `axisgate val3 password` has written")
    files = opened(data, secret)
    projects = [each[:-4] for each in files if each.lower().endswith(".pjx")]
    found = next((each for each in projects if f"{each}.zip".lower() == name.lower()), projects[0] if len(projects) == 1 else "")
    if not found:
        raise SealFault(12, f"the ZIP file has {len(projects) or 'no'} project files, one is expected")
    disk.unseal(folder, files)
    return folder, found


# ---- ZIP ----------------------------------------------------------------------------------------------------------------------


def opened(data: bytes, secret: str) -> dict[str, bytes]:
    """The files of an encrypted ZIP.  SealFault 23: not or badly encrypted; 12: wrong password, damaged."""
    try:
        return dict(_files(data, secret.encode()))
    except (struct.error, zlib.error, IndexError, UnicodeDecodeError) as error:
        raise SealFault(12, f"damaged ZIP file: {error}") from None


def _files(data: bytes, secret: bytes) -> Iterator[tuple[str, bytes]]:
    at = data.rfind(END)
    if at < 0:
        raise SealFault(23, "no ZIP file")
    count, _, place = struct.unpack_from("<HII", data, at + 10)
    total = 0
    for _ in range(count):
        if data[place : place + 4] != ENTRY:
            raise SealFault(12, "damaged directory of the ZIP file")
        flags, method, _, _, crc, packed, size, name_size, extra, comment = struct.unpack_from("<HHHHIIIHHH", data, place + 8)
        (local,) = struct.unpack_from("<I", data, place + 42)
        name = data[place + 46 : place + 46 + name_size].decode("utf-8" if flags & 0x0800 else "cp437").replace("\\", "/")
        place += 46 + name_size + extra + comment
        if name.endswith("/"):
            continue
        if not flags & ENCRYPTED or flags & STRONG or method not in (STORED, DEFLATED):
            raise SealFault(23, f"{name} is not encrypted with the classic ZIP encryption")
        total += size
        if total > LARGEST or ".." in name.split("/"):
            raise SealFault(12, f"{name}: more than {LARGEST} bytes, or a path out of the library")
        yield name, _content(data, local, packed, size, crc, method, secret)


def _content(data: bytes, local: int, packed: int, size: int, crc: int, method: int, secret: bytes) -> bytes:
    if data[local : local + 4] != LOCAL:
        raise SealFault(12, "damaged ZIP file")
    names, extra = struct.unpack_from("<HH", data, local + 26)
    begin = local + 30 + names + extra
    plain = decrypted(data[begin : begin + packed], secret)[12:]
    if method == DEFLATED:
        try:
            unpacker = zlib.decompressobj(-15)
            plain = unpacker.decompress(plain, size + 1)
        except zlib.error:
            raise SealFault(12, "wrong password") from None
    if len(plain) != size or zlib.crc32(plain) != crc:
        raise SealFault(12, "wrong password")
    return plain


def decrypted(data: bytes, secret: bytes) -> bytes:
    """The classic encryption of PKWARE."""
    first, second, third = 0x12345678, 0x23456789, 0x34567890
    for byte in secret:
        first = _next(first, byte)
        second = ((second + (first & 0xFF)) * 134775813 + 1) & 0xFFFFFFFF
        third = _next(third, second >> 24)
    found = bytearray()
    for byte in data:
        mask = third | 2
        byte ^= ((mask * (mask ^ 1)) >> 8) & 0xFF
        found.append(byte)
        first = _next(first, byte)
        second = ((second + (first & 0xFF)) * 134775813 + 1) & 0xFFFFFFFF
        third = _next(third, second >> 24)
    return bytes(found)


def _table() -> list[int]:
    made = []
    for start in range(256):
        value = start
        for _ in range(8):
            value = value >> 1 ^ (0xEDB88320 if value & 1 else 0)
        made.append(value)
    return made


TABLE = _table()


def _next(crc: int, byte: int) -> int:
    return crc >> 8 ^ TABLE[(crc ^ byte) & 0xFF]
