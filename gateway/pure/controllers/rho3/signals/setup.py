"""Settings of a cell for its rho 3: programs, bit numbers, boards, parameters."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.functions.plc import Settings
from gateway.pure.controllers.rho3.signals.coupling import Coupling
from gateway.pure.controllers.rho3.signals.fast_io import FastParts
from gateway.pure.controllers.rho3.signals.numbers import AS_SHIPPED, Numbers
from gateway.pure.controllers.rho3.signals.steps import Step
from gateway.pure.controllers.rho3.signals.whole import Installation
from gateway.pure.image.records.cell import RC_BYTES
from protocols.base.machine import Ns


@dataclass(frozen=True, slots=True)
class Declared:
    """A program of the cell."""

    name: str
    steps: tuple[Step, ...]
    permanent: bool = False
    priority: int = 140
    kinematics: tuple[int, ...] = (1,)
    repeat: bool = False


@dataclass(frozen=True, slots=True)
class Setup:
    """Settings from the cell; bit numbers of this cell."""

    installation: Installation = Installation()
    numbers: Numbers = AS_SHIPPED
    functions: Settings = field(default_factory=Settings)
    programs: tuple[Declared, ...] = ()
    axes: tuple[str, ...] = ()
    owners: Mapping[int, int] = field(default_factory=dict)  # RC input byte -> command source
    assumed: tuple[int, ...] = ()  # RC inputs that are not wired and count as 1
    of_cycle: bytes = bytes(RC_BYTES)  # RC output bits the cycle writes
    emergency_op: int = 140  # RC input: emergency mode without RC
    chain_assumed: bool = False
    fast: FastParts = FastParts()  # servo boards, P11, P36
    coupling: Coupling | None = None
    plc_silence: Ns = 0  # time-out of the PLC; 0: not supervised
    plc_grace: bool = True
    pic_timeout: Ns = 0  # longest time between two cycles of the PIC; 0: not supervised (AX-478)
    sets_override: bool = True
    units: tuple[tuple[str, float], ...] = ()  # of the axes: name, and how many of them a rad or m is
    limits: tuple[tuple[float, float], ...] = ()  # of the axes, in these units
    info_bits: Mapping[str, int] = field(default_factory=dict)  # RC inputs the pendant's INFO speaks of, by symbol
    option: int = 0  # P25 as the option byte: what resets factors
    p35: int = 0  # mode of the PHG 2000
    memory: int = 0  # bytes of the user memory; 0: there is none
    parameters: tuple[tuple[str, str], ...] = ()  # of mode 7.8.2: name, value
    password: str = ""  # of that mode
    pic: bool = False  # the interpreter scans a PIC program
    robot_masks: tuple[int, ...] = ()  # axes (bit n-1 = axis n) of each robot of the cell
