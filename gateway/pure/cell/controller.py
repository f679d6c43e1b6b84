"""[controller] of a cell: whose signals the image contains in addition to axisgate's own; without the table only those (AX-332)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Le, MaxLen, MinLen

from gateway.pure.cell.marks import Pattern, Percent, Registered, Unit

PointName = Annotated[str, Pattern(r"^[A-Za-z]\w*$", "letters, digits and _")]
BoardName = Literal[
    "servo-3/5/8-wide", "servo-abs-5/8", "servo-inc6/poti", "servo-3/5-narrow", "servo-3is/4is/6is", "servo-abs-3i", "modular-i"
]  # fmt: skip
CodeWord = Annotated[str, Pattern("^[A-Za-z0-9]{0,16}$", "up to 16 letters and digits")]
OutputByte = Annotated[int, Ge(0), Le(39)]


@dataclass(frozen=True, slots=True)
class ProcessStep:
    """One step of a process; exactly one of to, program, output, input, wait_ms."""

    to: Mapping[str, float] = field(default_factory=dict)  # axis -> target in its unit
    program: Annotated[int | None, Ge(0), Le(65535)] = None  # [[program]] of that number
    speed: Percent = "100 %"
    # binary channel: user output, or multi-function output 801..804
    output: Annotated[int | None, Ge(1), Le(804), Unit("binary output")] = None
    # binary channel: user input, high-speed input 6xy, multi-function input 801..804
    input: Annotated[int | None, Ge(1), Le(804), Unit("binary input")] = None
    value: bool = True
    wait_ms: Annotated[int | None, Ge(0), Le(3_600_000), Unit("ms")] = None


@dataclass(frozen=True, slots=True)
class ControllerProcess:
    """[[controller.process]]: what EXPROG.DAT or the panel may start under this name."""

    name: Annotated[str, Pattern("^[A-Za-z0-9_]{1,8}$", "up to 8 letters, digits and _")]
    steps: tuple[ProcessStep, ...] = ()
    kind: Literal["normal", "permanent"] = "normal"
    priority: Annotated[int, Ge(0), Le(255)] = 140
    kinematics: tuple[Annotated[int, Ge(1), Le(10)], ...] = (1,)
    repeat: bool = False


@dataclass(frozen=True, slots=True)
class ControllerPoint:
    """[[controller.point]]: a system input or output of VAL 3; digital at `bit`, analog at `byte` with `steps` per unit."""

    name: PointName
    board: Annotated[str, MinLen(1)]
    module: Annotated[str, MinLen(1)]
    address: Annotated[str, MinLen(1)]
    output: bool = False
    bit: Annotated[int | None, Ge(0), Le(1023)] = None
    byte: Annotated[int | None, Ge(0), Le(126)] = None
    steps: Annotated[int, Ge(0), Le(32767), Unit("steps per unit")] = 0
    min: float = 0.0
    max: float = 0.0
    integer: bool = False
    description: Annotated[str, MaxLen(200)] = ""  # free text, as ioStatus returns it


@dataclass(frozen=True, slots=True)
class ControllerPlc:
    """[controller.plc]: the integrated PLC of a Reis; without the table a command source writes the markers (AX-900)."""

    start: Annotated[str, MinLen(1)]  # start program (_SSTARTPLC), with FOLDER/ in front if it is in one
    path: Annotated[str, MinLen(1)] = "PLC"  # folder of NAME.PLC files (S:/PLC); relative to the cell file
    # commands a period (IPLC_LOAD); none: a complete scan each period; 0: the PLC is off
    load: Annotated[int | None, Ge(0), Le(1_000_000), Unit("commands")] = None
    watchdog: Annotated[int, Ge(1), Le(100), Unit("1/100 s")] = 30  # longest scan (_ITIME_PLC)


@dataclass(frozen=True, slots=True)
class ControllerStation:
    """[[controller.station]]: a table of a Reis cell; positions with this frame number are positions in its frame (AX-1052)."""

    number: Annotated[int, Ge(1), Le(64)]
    at: Annotated[tuple[float, ...], MinLen(6), MaxLen(6)]  # X Y Z in mm, A B C in degrees, in the basic system


@dataclass(frozen=True, slots=True)
class Controller:
    """[controller]: the control that is replaced, as its PLC sees it."""

    kind: Annotated[str, Registered("controllers")] = "rho3"
    files: str = ""  # folder of MSD.DAT, TEXT.DAT, EXPROG.DAT, PHGCODE.DAT; relative to the cell file
    memory: str = (
        ""  # folder of the programs: QLL, PKT, DAT, BNR (AX-860), of a reis MPR, SPR, MAC, PAL (AX-940); relative to the cell file
    )
    pic: Annotated[str, Pattern("^[A-Za-z][A-Za-z0-9_]{0,7}$|^$", "up to 8 letters, digits and _")] = (
        ""  # PIC program of the memory (AX-981)
    )
    eeprom: str = ""  # file that modes 9.6 and 9.7 of the pendant save the memory to (AX-1041); relative to the cell file
    printer: str = ""  # file or printer device that mode 9.4.2 of the pendant prints to (AX-1755); relative to the cell file
    password: Annotated[str, Pattern("^[0-9]{0,8}$", "up to 8 digits")] = ""  # of mode 7.8.2 of the pendant (AX-1757); "": none
    sram_card: str = ""  # file that is the SRAM card of a rho3.0 for mode 9.8 (AX-1756); its size is that of the card
    phg_unit: Literal["", "V24_1", "V24_2", "V24_3", "V24_4"] = ""  # unit of programs that is the screen of a PHG 2000 (AX-1042)
    code_page: Literal["cp437", "cp850", "latin-1", "utf-8"] = "cp437"
    hardware: Literal["rho3.0", "rho3.1", "rho3.2"] = "rho3.1"  # rho3.0 | rho3.1 | rho3.2: unit of timers, multi-function I/O
    kinematics: Annotated[int, Ge(1), Le(10)] = 1
    phg_option: bool = True  # option 41
    plc_silence_ms: Annotated[int, Ge(0), Le(600000), Unit("ms")] = 0  # time-out of the PLC; 0: not supervised here
    pic_timeout_ms: Annotated[int, Ge(0), Le(200), Unit("ms")] = 0  # longest time between two cycles of the PIC; 0: not supervised (AX-478)
    boards: Annotated[tuple[BoardName, ...], MaxLen(3)] = ()  # servo boards 1..3 that P11 counts inputs of; a rho3.0 has its own (AX-477)
    remote: bool = False  # frames of P20 also in blocks of 48 bytes
    command_source: str = ""  # reis: the command source markers command for; "": the only one
    first_byte: Annotated[int, Ge(0), Le(88), Unit("PIC byte")] = 88  # reis: where its 40 bytes lie
    plc_only: tuple[OutputByte, ...] = ()  # reis: output bytes of the PLC alone
    robot_only: tuple[OutputByte, ...] = ()
    code_words: Annotated[tuple[CodeWord, ...], MaxLen(2)] = ()  # reis: of setter and programmer at the pendant (AX-1660)
    pin: CodeWord = ""  # reis: of the manufacturer
    plc: ControllerPlc | None = None  # reis
    process: tuple[ControllerProcess, ...] = ()
    point: tuple[ControllerPoint, ...] = ()  # val3
    station: tuple[ControllerStation, ...] = ()  # reis
