"""[controller] of a cell: whose signals stand on the image beside axisgate's own; no table, ours alone (AX-332)."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class ProcessStep:
    """One step of a process; exactly one of to, program, output, input, wait_ms."""

    to: Mapping[str, float] = field(default_factory=dict)  # axis -> target in its unit
    program: int | None = None  # [[program]] of that number
    speed: str = "100 %"
    output: int | None = None  # binary channel: user output, or multi-function output 801..804
    input: int | None = None  # binary channel: user input, high-speed input 6xy, multi-function input 801..804
    value: bool = True
    wait_ms: int | None = None


@dataclass(frozen=True, slots=True)
class ControllerProcess:
    """[[controller.process]]: what EXPROG.DAT or the panel may start under this name."""

    name: str
    steps: tuple[ProcessStep, ...] = ()
    kind: str = "normal"  # normal | permanent
    priority: int = 140
    kinematics: tuple[int, ...] = (1,)
    repeat: bool = False


@dataclass(frozen=True, slots=True)
class ControllerPoint:
    """[[controller.point]]: a system input or output of VAL 3; digital at `bit`, analog at `byte` with `steps` per unit."""

    name: str
    board: str
    module: str
    address: str
    output: bool = False
    bit: int | None = None
    byte: int | None = None
    steps: int = 0
    min: float = 0.0
    max: float = 0.0
    integer: bool = False
    description: str = ""  # free text, as ioStatus tells it


@dataclass(frozen=True, slots=True)
class Controller:
    """[controller]: the control that is replaced, as its PLC sees it."""

    kind: str = "rho3"  # rho3 | reis | val3
    files: str = ""  # folder of MSD.DAT, TEXT.DAT, EXPROG.DAT, PHGCODE.DAT; relative to the cell file
    code_page: str = "cp437"
    hardware: str = "rho3.1"  # rho3.0 | rho3.1 | rho3.2: unit of timers, multi-function I/O
    kinematics: int = 1
    phg_option: bool = True  # option 41
    plc_silence_ms: int = 0  # time-out of the PLC; 0: not supervised here
    pic_timeout_ms: int = 0  # longest time between two cycles of the PIC; 0: not supervised (AX-478)
    boards: tuple[str, ...] = ()  # servo boards 1..3 that P11 counts inputs of; a rho3.0 has its own (AX-477)
    remote: bool = False  # frames of P20 also in blocks of 48 bytes
    door: str = ""  # reis: the command source markers command for; "": the only one
    first_byte: int = 88  # reis: where its 40 bytes lie
    plc_only: tuple[int, ...] = ()  # reis: output bytes of the PLC alone
    robot_only: tuple[int, ...] = ()
    process: tuple[ControllerProcess, ...] = ()
    point: tuple[ControllerPoint, ...] = ()  # val3
