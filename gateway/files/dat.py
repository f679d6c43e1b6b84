"""DAT files of a rho 3 from a folder: found under their English or German name in any case, read, parsed.

Their bytes are those of the old editors: code page 437, ended by CR LF and perhaps 1Ah (AX-533).
"""

import pathlib
from collections.abc import Callable
from dataclasses import dataclass

from gateway.pure.controllers.rho3.functions.dat_lines import Fault, Table
from gateway.pure.controllers.rho3.functions.dat_parsers import parse_exprog, parse_msd, parse_phgcode, parse_texts
from gateway.pure.controllers.rho3.functions.messages import Text

MOST_BYTES = 256 * 1024  # 256 lines of 80 characters and long comments; a larger file is not a DAT file
CODE_PAGE = "cp437"


@dataclass(frozen=True, slots=True)
class DatTables:
    """The four tables; None: no such file."""

    msd: Table[str] | None = None
    texts: Table[str] | None = None
    programs: Table[str] | None = None
    modes: Table[str] | None = None

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All bad lines of all files."""
        return tuple(fault for table in (self.msd, self.texts, self.programs, self.modes) if table for fault in table.faults)


def read_tables(folder: pathlib.Path, language: str = "en", encoding: str = CODE_PAGE) -> DatTables:
    """The tables of the folder; the German interface looks for the German names first (L672), both are found."""
    there = {path.name.upper(): path for path in sorted(folder.iterdir(), reverse=True) if path.is_file()} if folder.is_dir() else {}

    def read(parser: Callable[[str, str], Table[str]], english: str, german: str) -> Table[str] | None:
        names = (german, english) if language == "de" else (english, german)
        path = next((there[name] for name in names if name in there), None)
        return None if path is None else read_file(path, parser, encoding)

    return DatTables(
        read(parse_msd, "MSD.DAT", "MZA.DAT"),
        read(parse_texts, "TEXT.DAT", "TEXTE.DAT"),
        read(parse_exprog, "EXPROG.DAT", "EXPROG.DAT"),
        read(parse_phgcode, "PHGCODE.DAT", "PHGKODE.DAT"),
    )


def read_file(path: pathlib.Path, parser: Callable[[str, str], Table[str]], encoding: str = CODE_PAGE) -> Table[str]:
    """One file; where it cannot be read it is an empty table with a fault in line 0."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        return Table(path.name, {}, (Fault(path.name, 0, Text("unreadable", (error.strerror or str(error),))),))
    if len(data) > MOST_BYTES:
        return Table(path.name, {}, (Fault(path.name, 0, Text("large", (str(MOST_BYTES),))),))
    return parser(data.decode(encoding, "replace"), path.name)
