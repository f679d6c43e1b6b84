"""The tree of a program: what the reader makes of the tokens, before names are looked up.  Names are in upper case, as compared."""

from dataclasses import dataclass, field

from gateway.pure.languages.base.node import node
from gateway.pure.languages.base.source import Position

# ---- expressions


@node
class Number:
    at: Position
    value: int | float


@node
class Text:
    at: Position
    value: str


@node
class Name:
    """A variable, constant, channel, point ('@' belongs to its name) or a function without parameters."""

    at: Position
    name: str


@node
class Member:
    """`base.name`: component of a point, or a standard variable of a kinematic."""

    at: Position
    base: "Expression"
    name: str


@node
class Index:
    """`base[index]` of an array or a text."""

    at: Position
    base: "Expression"
    index: "Expression"


@node
class PointValue:
    """`(a, b, ..)` in world coordinates, `@(a, b, ..)` in joint coordinates."""

    at: Position
    values: "tuple[Expression, ...]"
    joint: bool


@node
class Call:
    """A function with its parameters."""

    at: Position
    name: str
    arguments: "tuple[Expression, ...]"


@node
class Unary:
    """`-x`, `+x`, `NOT x`, or `x %` (140 % is 1.4, L1878)."""

    at: Position
    sign: str
    value: "Expression"


@node
class Binary:
    at: Position
    sign: str
    left: "Expression"
    right: "Expression"


@node
class Faulty:
    """What was misread and reported; it fits everything."""

    at: Position


Expression = Faulty | Number | Text | Name | Member | Index | PointValue | Call | Unary | Binary

# ---- declarations


@node
class TypeName:
    """A type as it is written.  `base`: token of the type word; bounds of an array; kinematic and element type where given."""

    at: Position
    base: str
    kinematic: str = ""
    low: Expression | None = None
    high: Expression | None = None
    element: str = ""  # of FILE: type of contents of the file


@node
class Declared:
    """One name of a declaration.  `channel`: of inputs, outputs, belts."""

    at: Position
    name: str
    type: TypeName
    channel: Expression | None = None
    public: bool = False
    teach: bool = False  # DEF


@node
class Constant:
    at: Position
    name: str
    value: Expression


@node
class External:
    """`EXTERNAL program : names`; without a program the names are programs."""

    at: Position
    program: str
    names: tuple[tuple[str, Position], ...]


@node
class Parameter:
    at: Position
    name: str
    type: TypeName
    by_value: bool


@node
class SpecialFunction:
    at: Position
    number: Expression
    name: str
    parameters: tuple[Parameter, ...]


Declaration = Declared | Constant | External | SpecialFunction

# ---- statements


@node
class Label:
    at: Position
    name: str


@node
class Instruction:
    """A compiler instruction among the statements: KINEMATICS = name, INT = LINEAR."""

    at: Position
    word: str
    value: str


@node
class Set:
    at: Position
    target: Expression
    value: Expression


@node
class Leg:
    """One target of a MOVE.  `through`: VIA, the point is passed."""

    point: Expression
    through: bool


@node
class Move:
    at: Position
    relative: bool
    kinematic: str
    way: str  # "" the default, PTP, LINEAR, CIRCULAR
    factors: tuple[tuple[str, Expression], ...]  # WITH name = value
    until: Expression | None
    until_time: Expression | None
    otherwise: "Statement | None"
    legs: tuple[Leg, ...]


@node
class Wait:
    at: Position
    seconds: Expression


@node
class WaitUntil:
    at: Position
    condition: Expression
    max_time: Expression | None
    otherwise: "Statement | None"


@node
class If:
    at: Position
    condition: Expression
    then: "Statement"
    otherwise: "Statement | None"


@node
class Block:
    at: Position
    body: "tuple[Statement, ...]"


@node
class Choice:
    at: Position
    values: tuple[Expression, ...]
    body: "Statement"


@node
class Case:
    at: Position
    selector: Expression
    choices: tuple[Choice, ...]
    otherwise: "Statement | None"


@node
class Repeat:
    at: Position
    times: Expression
    body: "tuple[Statement, ...]"


@node
class Parallel:
    at: Position
    branches: "tuple[tuple[Statement, ...], ...]"


@node
class Exclusive:
    at: Position
    semaphore: str
    body: "tuple[Statement, ...]"


@node
class Jump:
    at: Position
    label: str


@node
class Simple:
    """HALT, BREAK, REF_PNT and SYNCHRON_END (with its belt)."""

    at: Position
    word: str
    name: str = ""


@node
class StartStop:
    at: Position
    word: str  # START, STOP
    program: str


@node
class Sync:
    """`SYNC belt, input = 1` or `SYNC belt >= mm`: the belt counter is set, or waited for."""

    at: Position
    belt: str
    condition: Expression


@node
class Synchron:
    at: Position
    kinematic: str
    belt: str


@node
class Read:
    at: Position
    device: str  # "": the PHG
    targets: tuple[Expression, ...]


@node
class Write:
    at: Position
    device: str
    values: tuple[Expression, ...]
    open: bool  # `..`: the output continues with the next WRITE


@node
class FileOrder:
    """READ_BEGIN, WRITE_BEGIN, WRITE_END, CLOSE, ASSIGN; `value`: offset or name."""

    at: Position
    word: str
    file: str
    value: Expression | None = None


@node
class CallStatement:
    at: Position
    name: str
    arguments: tuple[Expression, ...]
    behind: tuple[Position, str] | None = None  # what follows it and begins no statement: one of the two is a mistake


Statement = (
    Label
    | Instruction
    | Set
    | Move
    | Wait
    | WaitUntil
    | If
    | Block
    | Case
    | Repeat
    | Parallel
    | Exclusive
    | Jump
    | Simple
    | StartStop
    | Sync
    | Synchron
    | Read
    | Write
    | FileOrder
    | CallStatement
)

# ---- programs


@node
class Routine:
    """The main part of a program, or a subroutine."""

    at: Position
    name: str
    parameters: tuple[Parameter, ...]
    declarations: tuple[Declaration, ...]
    body: tuple[Statement, ...]
    garbled: bool = False  # its parameters are misread and reported


@dataclass(slots=True)
class Head:
    """The compiler instructions of a program."""

    control: str = ""
    kinematics: dict[str, int] = field(default_factory=dict)  # name -> number
    joint_names: dict[str, tuple[str, ...]] = field(default_factory=dict)  # kinematic ("": the default) -> component names
    world_names: dict[str, tuple[str, ...]] = field(default_factory=dict)
    permanent: bool = False
    file_error: bool = True  # False: a file error does not end the program
    serial_stop: bool = True  # False: a fault of an interface does not end the program
    default_kinematic: str = ""
    default_way: str = ""
    said: set[str] = field(default_factory=set)  # instructions that may occur once
    faulty: set[str] = field(default_factory=set)  # instructions that are read in part
    over: bool = False  # the main part has been read
    commented: dict[str, int] = field(default_factory=dict)  # names in a comment directly after declared ones -> line


@node
class Program:
    """A complete source: main part and subroutines."""

    head: Head
    main: Routine
    subroutines: tuple[Routine, ...]
    external_subroutine: bool = False  # the file has a SUBROUTINE and no PROGRAM, or its PROGRAM has parameters
