"""The user memory: all files by name.  QLL sources are the program store; PKT files hold points as text (AX-695)."""

import re
from collections.abc import Iterable

from gateway.pure.languages.baps2.translated import age_of
from gateway.pure.languages.baps2.types import CODE_PAGE
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position

_POINT = re.compile(r"(?:[^\W\d]\w*\s*\.\s*)?(@?[^\W\d]\w*(?:\s*\[\s*-?\d+\s*\])?)\s*=\s*@?\s*\(?\s*([^()]*?)\s*\)?")
_DOS = re.compile(rb"[A-Za-z][\x81\x84\x94\xe1]|[\x81\x84\x94\x8e\x99\x9a][a-z]")  # umlauts in words, with code page 437
_WINDOWS = re.compile(rb"[A-Za-z][\xfc\xe4\xf6\xdf]|[\xfc\xe4\xf6\xc4\xd6\xdc][a-z]")
Points = dict[str, tuple[float, ...]]
POINT_DIGITS = 9  # after the decimal point: further digits of an angle of 0 are rounding residue


def decoded(data: bytes) -> str:
    """A source as text: UTF-8 or UTF-16 where it is that, else the code page of the controller, or of Windows where words have its umlauts
    (AX-1748).  1Ah ends it, as the DOS editors wrote it."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    data = data.partition(b"\x1a")[0]
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        windows = len(_WINDOWS.findall(data)) > len(_DOS.findall(data))
        return data.decode("cp1252", "replace") if windows else data.decode(CODE_PAGE)


class Memory:
    """Files by name in upper case; a program store.  `compiled`: programs, the oldest translation first."""

    def __init__(self, files: dict[str, bytes], compiled: Iterable[str] = ()) -> None:
        self.files = {name.upper(): data for name, data in files.items()}
        self._ages = {name.upper(): age for age, name in enumerate(compiled)}

    def names(self) -> Iterable[str]:
        """All files, sorted."""
        return sorted(self.files)

    def text(self, name: str) -> str | None:
        """A file as text."""
        data = self.files.get(name.upper())
        return None if data is None else decoded(data)

    def age(self, name: str) -> int | None:
        """Place of a program in the order of translation: as given, else as in its IRD file."""
        name = name.upper().removesuffix(".QLL")
        return self._ages.get(name) if self._ages else age_of(self.text(f"{name}.IRD"), self.text(f"{name}.QLL"))

    def newest(self, name: str) -> None:
        """Append a program just translated to a given order of translations."""
        if self._ages:
            self._ages[name.upper()] = max(self._ages.values()) + 1

    def keep_point(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """Writes a point into the program's PKT file."""
        file = f"{program}.PKT"
        self.files[file] = with_point(self.text(file) or "", name, value).encode()

    def points(self, program: str, faults: Faults) -> Points:
        """The points of a program's PKT file."""
        text = self.text(f"{program}.PKT")
        return {} if text is None else points_of(text, f"{program}.PKT", faults)


def _named(match: re.Match[str]) -> str:
    """NAME, or NAME[3] of an array."""
    return "".join(match[1].upper().split())


def with_point(text: str, name: str, value: tuple[float, ...]) -> str:
    """The text of a point file with this point in it: in its line, with the comment there, or in a new one at the end."""
    line = f"{name} = {'@' if name.startswith('@') else ''}({', '.join(f'{round(each, POINT_DIGITS) + 0.0:.10g}' for each in value)})"
    rows, found = text.splitlines(), False
    for index, row in enumerate(rows):
        match = _POINT.fullmatch(row.partition(";")[0].strip())
        if match is not None and _named(match) == name:
            comment = row[row.index(";") :] if ";" in row else ""
            rows[index], found = f"{line} {comment}".rstrip(), True
    return "\n".join([*rows, *([] if found else [line]), ""])


def points_of(text: str, file: str, faults: Faults) -> Points:
    """Lines `NAME = (1, 2, 3)`, `NAME[2] = (1, 2, 3)`; `;` begins a comment, `@(` and a kinematic in front are taken too."""
    found: Points = {}
    for number, line in enumerate(text.splitlines(), 1):
        row = line.partition(";")[0].strip()
        match = _POINT.fullmatch(row)
        if row and match is None:
            faults.error("point-line", Position(file, number), f"{row[:40]!r} is not a point", "the form is NAME = (1, 2, 3)")
        elif match is not None:
            try:
                found[_named(match)] = tuple(float(each) for each in re.split(r"[\s,]+", match[2].strip(", ")))
            except ValueError:
                faults.error("point-line", Position(file, number), f"{match[2][:40]!r} are not numbers", "the form is NAME = (1, 2, 3)")
    return found
