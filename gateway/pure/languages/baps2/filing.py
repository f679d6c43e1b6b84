"""Files of the user memory as programs see them: DAT in lines, BNR in bytes (rho 3 releases L5646-5750, 6865-6954)."""

import re
from dataclasses import dataclass

from gateway.pure.languages.baps2 import forms
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.standard import DEVICES

_NAME = re.compile(r"([A-Z][A-Z0-9_]{0,7})(\.([A-Z][A-Z0-9_]{0,2}| {0,3})?)?")
_DEVICE = re.compile(r"([A-Z][A-Z0-9_]*)(\. {0,3})?")
LINE_END = b"\r\n"


def file_name(text: str) -> str | None:
    """Return the name of a file or device as ASSIGN accepts it; None: not allowed.  `X` is X.DAT, `X.` has three blanks (L5682-5699)."""
    text = text.partition("\0")[0]
    device = _DEVICE.fullmatch(text.rstrip())
    if device is not None and device[1] in DEVICES:
        return device[1]
    match = _NAME.fullmatch(text.rstrip() if "." not in text else text)
    if match is None:
        return None
    return f"{match[1]}.DAT" if match[2] is None else f"{match[1]}.{(match[3] or '').ljust(3)}"


@dataclass(slots=True)
class Opened:
    """A file that is open.  `owner`: number of the process."""

    owner: int
    writing: bool
    data: bytearray
    place: int = 0


class Filing:
    """All files by name, and which are open."""

    def __init__(self, files: dict[str, bytes]) -> None:
        self.files = files
        self.written: set[str] = set()  # names that programs have written
        self._open: dict[str, list[Opened]] = {}

    def is_open(self, name: str) -> bool:
        """Whether any process has it open."""
        return bool(self._open.get(name))

    def opened(self, name: str, owners: list[int], writing: bool) -> Opened | None:
        """The opening of one of these processes."""
        return next((each for each in self._open.get(name, ()) if each.owner in owners and each.writing == writing), None)

    def begin_reading(self, name: str, owner: int, offset: int, binary: bool) -> None:
        """READ_BEGIN.  Again by the same process: it is placed anew."""
        if any(each.writing for each in self._open.get(name, ())):
            raise fault(1057, name)
        if name not in self.files:
            raise fault(213, name)
        data = bytearray(self.files[name])
        place = offset if binary else _line_start(data, offset)
        if not 0 <= place <= len(data):
            raise fault(218, f"offset {offset} of {name}, which has {len(data)} bytes")
        self._forget(name, owner)
        self._open.setdefault(name, []).append(Opened(owner, False, data, place))

    def begin_writing(self, name: str, owner: int, offset: int | None, binary: bool) -> None:
        """WRITE_BEGIN, or WRITE_END with offset None."""
        others = [each for each in self._open.get(name, ()) if each.owner != owner]
        if others:
            raise fault(1057, name)
        data = self.files.get(name, b"")
        kept = len(data) if offset is None else offset if binary else _line_start(data, offset)
        if not 0 <= kept <= len(data):
            raise fault(218, f"offset {offset} of {name}, which has {len(data)} bytes")
        self._forget(name, owner)
        self._open.setdefault(name, []).append(Opened(owner, True, bytearray(data[:kept])))

    def _forget(self, name: str, owner: int) -> None:
        self._open[name] = [each for each in self._open.get(name, ()) if each.owner != owner]

    def close(self, name: str, owner: int) -> None:
        """CLOSE a file opened by this process; its written data is now in the file."""
        for each in self._open.get(name, ()):
            if each.owner == owner and each.writing:
                self.files[name] = bytes(each.data)
                self.written.add(name)
        self._forget(name, owner)

    def any_open(self) -> bool:
        """Whether a program has a file open."""
        return any(self._open.values())

    def close_all(self, owner: int) -> None:
        """A process is over."""
        for name in list(self._open):
            self.close(name, owner)


def read(opened: Opened, base: str, size: int, binary: bool) -> object:
    """The next value."""
    rest = bytes(opened.data[opened.place :])
    if binary:
        need = forms.bytes_of(base, size, True)
        if len(rest) < need:
            raise fault(219)
        value: object = forms.decode_binary(base, size, rest[:need], True)
        opened.place += need
        return value
    if not rest:
        raise fault(219)
    value, taken = forms.decode_letters(base, size, rest)
    opened.place += taken
    return value


def _line_start(data: bytes | bytearray, line: int) -> int:
    """Where a line begins; the first is 1, and 0 means it too.  Behind the last line: the end."""
    at = 0
    for _ in range(max(0, line - 1)):
        end = data.find(b"\n", at)
        if end < 0:
            return len(data)
        at = end + 1
    return at
