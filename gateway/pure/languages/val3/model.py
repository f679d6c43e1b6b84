"""What the files of an application declare, as plain data: types, data, programs, projects."""

from dataclasses import dataclass, field
from typing import TypeAlias

from gateway.pure.languages.base.source import Position

NUM, BOOL, STRING = "num", "bool", "string"
SIMPLE = ("bool", "num", "string", "dio", "aio", "sio", "screen")
STRUCTURED = ("trsf", "frame", "tool", "point", "joint", "config", "mdesc")
BUILT_IN = frozenset(SIMPLE + STRUCTURED)
FAMILIES = {"rx": 6, "rs": 4}  # arm family -> axes
FIELDS: dict[str, dict[str, str]] = {
    "trsf": dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), "num"),
    "frame": {"trsf": "trsf"},
    "tool": {"trsf": "trsf", "gripper": "dio", "otime": "num", "ctime": "num"},
    "point": {"trsf": "trsf", "config": "config"},
    "config": {"shoulder": "shoulder", "elbow": "elbow", "wrist": "wrist"},
    "mdesc": {
        "accel": "num",
        "vel": "num",
        "decel": "num",
        "tvel": "num",
        "rvel": "num",
        "blend": "blend",
        "leave": "num",
        "reach": "num",
    },
}
WORDS: dict[str, tuple[str, ...]] = {
    "shoulder": ("righty", "lefty", "ssame", "sfree"),
    "elbow": ("epositive", "enegative", "esame", "efree"),
    "wrist": ("wpositive", "wnegative", "wsame", "wfree"),
    "blend": ("off", "joint", "Cartesian"),
}
MOST_VALUES = 9999  # insert, append and resize make no more (L1141)
MOST_IN_FILES = 99_999  # files of s8.15 declare 10000
MOST_TOGETHER = 1_000_000  # of a variable with all that its user types are made of


@dataclass(eq=False, slots=True)
class UserType:
    """A type made of the public data of an application."""

    name: str
    path: str
    fields: "dict[str, Declaration]" = field(default_factory=dict)
    millimetres: bool = True
    partial: bool = False  # some of its data cannot be read

    def __str__(self) -> str:
        return self.name


Type: TypeAlias = str | UserType


@dataclass(slots=True)
class Initial:
    """One value of a data element as the file writes it."""

    key: str
    attributes: dict[str, str]
    fields: "dict[str, Declaration]"
    line: int
    column: int = 1


@dataclass(slots=True)
class Declaration:
    """A datum: dims 1, 2 or 3 for arrays, 0 for a collection."""

    name: str
    type_name: str
    dims: int = 1
    sizes: tuple[int, ...] = (1,)
    public: bool = False
    values: list[Initial] = field(default_factory=list)
    file: str = ""
    line: int = 1
    type: Type = "num"
    family: str = ""  # of jointRx and its like
    broken: bool = False  # its type is not there
    column: int = 1

    @property
    def place(self) -> Position:
        """Where its file declares it."""
        return Position(self.file, self.line, self.column)


@dataclass(slots=True)
class Parameter:
    """Parameter of a program.  `reference`: by reference; `whole`: the container, not one value."""

    name: str
    type_name: str
    reference: bool = False
    whole: bool = False
    dims: int = 1
    line: int = 1
    column: int = 1
    type: Type = "num"
    broken: bool = False


@dataclass(slots=True)
class ProgramText:
    """A program: its lines count from `begin`, which is line 1."""

    name: str
    file: str
    public: bool
    parameters: list[Parameter]
    locals: list[Declaration]
    lines: list[str]
    line: int = 1
    lost: set[str] = field(default_factory=set)  # parameters and locals that cannot be read


@dataclass(slots=True)
class Use:
    """A library identifier or a user type and the application it points to."""

    name: str
    path: str
    line: int
    autoload: bool = False
    password: str | None = None  # of an encrypted library
    column: int = 1


@dataclass(slots=True)
class Application:
    """One application as read: project, data, programs."""

    name: str
    path: str  # folder on the disk, "" where it lies at the top
    version: str = ""
    stack: int = 5000
    millimetres: bool = True
    data: dict[str, Declaration] = field(default_factory=dict)
    programs: dict[str, ProgramText] = field(default_factory=dict)
    libraries: dict[str, Use] = field(default_factory=dict)
    types: dict[str, Use] = field(default_factory=dict)
    resolved: dict[str, UserType] = field(default_factory=dict)
    interfaces: "dict[str, Application | None]" = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)  # data that cannot be read
    lost_data: bool = False  # an entire file of them
    lost_programs: bool = False
    lost_libraries: set[str] = field(default_factory=set)  # and user types

    @property
    def since_s8(self) -> bool:
        """Its controller was an s8 or later."""
        return self.version[:2].lower() not in ("", "s7")

    @property
    def project(self) -> str:
        """The project file on the disk."""
        return f"{self.path}/{self.name}.pjx" if self.path else f"{self.name}.pjx"
