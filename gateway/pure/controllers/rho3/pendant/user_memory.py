"""The user memory as the pendant sees it: its files, the lines of its text lists, its key assignment (AX-1041).

The interpreter has the files; it reports them piece by piece, and again what has changed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.functions.system_variables import FileEntry
from gateway.pure.controllers.rho3.pendant.keys import KeyTable
from gateway.pure.image.records.interpreter import Fact
from gateway.pure.image.system_errors import system_code

SIZES = {"rho3.0": 128 * 1024, "rho3.1": 96 * 1024, "rho3.2": 96 * 1024}  # of the user memory (L4854-4856)
MOST_LINES, LISTS = 999, 256


@dataclass(frozen=True, slots=True)
class PointFile:
    """Points of a PKT file as modes 4.1 and 4.2 offer them: name and components of each; top: the one that is offered first; size:
    components of one that is not defined."""

    name: str
    points: tuple[tuple[str, str], ...] = ()
    top: int = 0
    size: int = 0

    def components(self, place: int) -> int:
        """Of a point."""
        return len(self.points[place][1].split()) or self.size


@dataclass(slots=True)
class UserMemory:
    """Its mirror in the services."""

    files: tuple[FileEntry, ...] = ()
    lists: dict[int, list[str]] = field(default_factory=dict)  # number of VTLnnn.DAT -> its lines
    keys: KeyTable = field(default_factory=KeyTable)
    ordered: tuple[str, int] = ("", 0)  # of mode 9.4.2, 9.6 or 9.7: print, save or load, ticket
    taught: tuple[str, str, int] = ("", "", 0)  # file, point, ticket of mode 4.2
    typed: dict[tuple[str, str], dict[int, float]] = field(default_factory=dict)  # file, point -> components that wait for the others
    selected: PointFile | None = None  # by special function 16, for the next selection of a mode (L10776-10833)
    opened: PointFile | None = None  # in the mode that is selected
    unlocked: bool = False  # the password was entered in mode 7.8.2, until it is left
    system_error: int = 0  # of the SRAM card: 39 or 300, until a restart
    card: int = 0  # bytes of the SRAM card that is the memory; 0: none
    _coming: list[FileEntry] = field(default_factory=list)
    _points: list[tuple[str, str]] = field(default_factory=list)

    @property
    def error_code(self) -> int:
        """Of the coded error output; 0: none."""
        return system_code(self.system_error) if self.system_error else 0

    def hear(self, said: Mapping[str, Fact]) -> None:
        """One piece."""
        rows = str(said["text"]).split("\n") if said["text"] != "" or said["part"] == "list" else []
        match said["part"]:
            case "files":
                if said["first"] == 0:
                    self._coming.clear()
                self._coming += [FileEntry(name, int(size), day, time) for name, size, day, time in (row.split("|") for row in rows)]
                if len(self._coming) >= int(said["of"]):
                    self.files = tuple(self._coming)
            case "list":
                lines = self.lists.setdefault(int(said["number"]), [])
                del lines[int(said["first"]) :]
                lines += rows[: int(said["of"]) - len(lines)]
            case "no list":
                self.lists.pop(int(said["number"]), None)
            case "card":
                self.system_error, self.card = self.system_error or int(said["error"]), int(said["size"])
            case "points":
                self._hear_points(said, rows)
            case "keys":
                self.keys.load(bytes.fromhex(str(said["text"])))

    def _hear_points(self, said: Mapping[str, Fact], rows: list[str]) -> None:
        """A point file: of special function 16, or as the operator has chosen it."""
        if said["first"] == 0:
            self._points.clear()
        self._points += [(name, values) for name, _, values in (row.partition(" ") for row in rows)]
        if len(self._points) < int(said["of"]):
            return
        names = [name for name, _ in self._points]
        top = names.index(str(said["point"])) if said["point"] in names else 0
        found = PointFile(str(said["file"]), tuple(self._points), top, int(said["size"]))
        if said["select"]:
            self.selected = found
        else:
            self.opened = found

    def enter(self, *, points: bool) -> int:
        """A mode is selected; points: it offers point files.  The row it begins with; a selection is used up by it."""
        self.ordered, self.taught, self.unlocked = ("", 0), ("", "", 0), False
        self.typed.clear()
        self.opened, self.selected = (self.selected, None) if points else (None, self.selected)
        return self.opened.top if self.opened is not None else 0
