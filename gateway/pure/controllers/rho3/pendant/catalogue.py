"""Every PHG 2000 variable by its number.  Source: rho 3 Releases L9269-9470; rho3 3.8, AX-486.

Processes and files (34305..34570) are read and written by gateway.pure.controllers.rho3.functions.system_variables; their rows are here
too.
"""

from dataclasses import dataclass
from enum import Enum

from gateway.pure.controllers.rho3.functions.system_variables import VariableError

CODED = 32768  # bit 15: the index holds kinematic and component


class Access(Enum):
    """What a pendant may do."""

    READ = "R"
    WRITE = "W"
    BOTH = "R/W"


class Base(Enum):
    """Base types of the BDT editor."""

    BIT = "Bit"
    BYTE = "Byte"
    WORD = "Word"
    DOUBLE = "Double"
    REAL = "Real"
    STRING = "String"


@dataclass(frozen=True, slots=True)
class Variable:
    """One row: index from first to last, both 0 with `single` for a variable that is not an array."""

    code: int
    name: str
    base: Base
    first: int
    last: int
    single: bool
    access: Access

    @property
    def readable(self) -> bool:
        return self.access is not Access.WRITE

    @property
    def writable(self) -> bool:
        return self.access is not Access.READ


_ROWS = """
33025 Bit 0 1023 R PIC inputs bit
33026 Bit 0 1023 R PIC outputs (RCI) bit
33027 Bit 0 1023 R PIC flags bit
33028 Byte 0 127 R PIC inputs byte
33029 Byte 0 127 R PIC outputs (RCI) byte
33030 Byte 0 127 R PIC flags byte
33031 Word 0 126 R PIC inputs word
33032 Word 0 126 R PIC outputs (RCI) word
33033 Word 0 126 R PIC flags word
33034 Double 0 124 R PIC inputs double
33035 Double 0 124 R PIC outputs (RCI) double
33036 Double 0 124 R PIC flags double
33037 Bit 64 511 R/W RC outputs bit
33038 Byte 8 63 R/W RC outputs byte
33039 Word 8 62 R/W RC outputs word
33040 Double 8 60 R/W RC outputs double
33041 Bit 640 703 R/W MTB PIC inputs bit
33042 Byte 80 87 R/W MTB PIC inputs byte
33043 Word 80 86 R/W MTB PIC inputs word
33044 Double 80 84 R/W MTB PIC inputs double
33045 Bit 0 15 R SB1 inputs bit
33046 Bit 0 15 R SB2 inputs bit
33047 Bit 0 15 R SB3 inputs bit
33048 Bit 0 15 R SB1 outputs bit
33049 Byte 0 1 R SB1 inputs byte
33050 Byte 0 1 R SB2 inputs byte
33051 Byte 0 1 R SB3 inputs byte
33052 Byte 0 1 R SB1 outputs byte
33053 Word 0 0 R SB1 inputs word
33054 Word 0 0 R SB2 inputs word
33055 Word 0 0 R SB3 inputs word
33056 Word 0 0 R SB1 outputs word
33057 Byte - - R Number of analog inputs
33058 Byte - - R Number of analog outputs
33059 Real 1 32 R Analog inputs
33060 Real 1 32 R Analog outputs
33281 Real 1 32 R JC position Set
33282 Real 1 32 R JC position Actual
33283 Real 1 32 R JC position Set
33285 Real 1 32 R OC position
33286 Real 1 32 R GC position
33287 Real 1 32 R SW limit switch positive WC
33288 Real 1 32 R SW limit switch negative WC
33289 Real 1 32 R SW limit switch positive JC
33290 Real 1 32 R SW limit switch negative JC
33291 String 1 32 R Axis names
33292 String 1 32 R Coordinate names
33293 Real 1 32 R Lag
33294 String 1 32 R Inpos
33295 Real 1 32 R Offset
33296 Real 1 32 R End point
33297 Byte - - R Number of axes
33298 Byte - - R Number of belts
33299 Real 1 8 R Belt
33300 String 1 8 R Belt names
33537 Byte 1 16 R No. of axes kinematics-dependent
33538 Byte 1 16 R No. of belts kinematics-dependent
33539 String 1 16 R Tool name
33540 Real coded coded R Tool
33541 Real coded coded R WC system
33793 Real - - R/W VFACTOR global
33794 Real - - R/W AFACTOR global
33795 Real - - R/W DFACTOR global
33796 Real - - R VFACTOR global limit min
33797 Real - - R VFACTOR global limit max
33798 Real - - R AFACTOR global limit min
33799 Real - - R AFACTOR global limit max
33800 Real - - R DFACTOR global limit min
33801 Real - - R DFACTOR global limit max
33802 Real 1 16 R/W VFACTOR kin
33803 Real 1 16 R/W AFACTOR kin
33804 Real 1 16 R/W DFACTOR kin
33805 Real 1 16 R VFACTOR kin limit min
33806 Real 1 16 R VFACTOR kin limit max
33807 Real 1 16 R AFACTOR kin limit min
33808 Real 1 16 R AFACTOR kin limit max
33809 Real 1 16 R DFACTOR kin limit min
33810 Real 1 16 R DFACTOR kin limit max
34049 Word - - R Clock time [ms]
34050 String - - R/W Time
34051 String - - R/W Date
34052 String - - R/W Date/time
34053 String - - R Version P1
34054 String - - R Version P2
34055 String - - R Version SB1
34056 String - - R Version SB2
34057 String - - R Version SB3
34058 String - - R Version 8085
34059 String - - R PIC program name
34060 Word - - R Number of warnings
34061 Word - - R Number of errors
34062 String 1 32 R Warning ASCII axes + code
34063 String 1 32 R Warning ASCII + axes
34064 String 1 32 R Warning ASCII
34065 Word 1 32 R Warning axis-coded
34066 Word 1 32 R Warning code
34067 String 1 32 R Error ASCII axes + code
34068 String 1 32 R Error ASCII + axes
34069 String 1 32 R Error ASCII
34070 Word 1 32 R Error axis-coded
34071 Word 1 32 R Error code
34305 Word - - R Number of normal processes
34306 Word - - R Number of permanent processes
34307 Word - - R Number of sub-processes
34308 Word - - R Number of incorrect processes
34309 String 1 100 R Process list
34310 Word - - R/W Selected process
34311 String - - R Process type
34312 Word - - R Process priority
34313 String - - R Process status
34314 String - - R External program
34315 Byte - - R Program level
34316 String - - R Process name
34317 Word - - R QLL line
34318 Word - - R QLL INCLUDE line
34319 Word - - R Kinematics
34320 Word - - R Process error code
34321 String - - R Process error text
34322 Byte - - W Stop process
34561 String 1 1000 R List file name/size/date
34562 String 1 1000 R List file name/size
34563 String 1 1000 R List file name/date
34564 String 1 1000 R List file name
34565 Double - - R Cursor index
34566 Double - - R Control variable
34567 Double - - R Memory allocation
34568 Double - - R Memory available
34569 Double - - R Memory used
34570 Double - - R Free memory
"""


def _variable(row: str) -> Variable:
    code, base, first, last, access, name = row.split(maxsplit=5)
    single = first == "-"
    ends = (0, 0) if single or first == "coded" else (int(first), int(last))
    return Variable(int(code), name, Base(base), *ends, single, Access(access))


TEXT_LISTS = range(34816, 35072)  # VTL000.DAT .. VTL255.DAT: the index is the line, 1..999
TABLE = {variable.code: variable for variable in map(_variable, _ROWS.strip().splitlines())} | {
    code: Variable(code, f"VTL{code - TEXT_LISTS.start:03d}", Base.STRING, 1, 999, False, Access.READ) for code in TEXT_LISTS
}


def coded_index(kinematic: int, component: int) -> int:
    """Index of a component (axis, belt, coordinate) of one kinematic; ValueError outside 1..127 and 1..255 (L9355-9365)."""
    if not 1 <= kinematic <= 127 or not 1 <= component <= 255:
        raise ValueError(f"kinematic {kinematic}, component {component}: 1..127 and 1..255")
    return CODED + 256 * kinematic + component


def split_index(index: int) -> tuple[int, int]:
    """Return (kinematic, component) of a coded index; (0, index) of a simple one, which counts over the entire system."""
    return divmod(index - CODED, 256) if index & CODED else (0, index)


PREFIX = "phg."  # of the names cells and tools use (AX-496)
NOT_HERE = (  # codes from .. to: nothing of the kind is in this control
    (33041, 33060), (33285, 33288), (33292, 33292), (33295, 33296), (33299, 33300), (33539, 33541), (34050, 34059),
)  # fmt: skip


def variable_of(name: str) -> tuple[Variable, int]:
    """Return row and index of a name.  Raise KeyError when it does not name a variable, VariableError for an unknown variable or index."""
    parts = name.removeprefix(PREFIX).split(".")
    if not name.startswith(PREFIX) or not 1 <= len(parts) <= 3 or not all(part.isascii() and part.isdigit() for part in parts):
        raise KeyError(name)
    code, *rest = (int(part) for part in parts)
    variable = TABLE.get(code)
    if variable is None:
        raise VariableError(f"{name}: no such variable; rho 3 Releases L9288-9470 has 33025 to 35071")
    if any(first <= code <= last for first, last in NOT_HERE):
        raise VariableError(f"{name} {variable.name}: this control has none")
    try:
        return variable, coded_index(*rest) if len(rest) == 2 else rest[0] if rest else 0
    except ValueError as error:
        raise VariableError(f"{name}: {error}") from error


def register_type(name: str) -> str:
    """Form of a number in registers where the cell names no type."""
    base = variable_of(name)[0].base
    return {Base.REAL: "REAL", Base.DOUBLE: "UINT32"}.get(base, "UINT16")
