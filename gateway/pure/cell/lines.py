"""[[line]], [[db]], [handshake.NAME] and [[telegram]] of a cell: how a PLC or host is connected.  Shapes: users.md 3.4."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Le

from gateway.pure.cell.marks import BAUDS, OWN_NAME, Name, OnLoss, Pattern, Registered, Spelled, Unit

PORTS = "sim | /dev/... | COM5 | pty:/path | tcp://host:port | rfc2217://host:port"
LinePort = Annotated[str, Pattern(r"^(sim|/dev/\S+|COM\d+|pty:\S+|tcp://\S+:\d+|rfc2217://\S+:\d+)$", PORTS)]
LONGEST = 4000  # bytes of a block at the station with the highest limit; each profile has its own limit, which `check` knows
ENGLISH = {"I": "E", "Q": "A", "F": "M", "C": "Z", "DB": "D", "DX": "X"}  # S7 and English STEP 5; users.md 3.2


def german(letter: object) -> object:
    """I Q F C are E A M Z."""
    return ENGLISH.get(letter, letter) if isinstance(letter, str) else letter


AreaLetter = Annotated[Literal["D", "X", "E", "A", "M", "T", "Z"], Spelled(german)]
NumberForm = Literal["bit", "KF", "DH", "KH", "KM", "KY", "KC", "KT", "KZ", "KG", "REAL", "BCD"]  # STEP 5
Hex = Annotated[str, Pattern(r"^\s*([0-9A-Fa-f]{2}\s*)+$", '"00 4F", two hex digits a byte')]
Text = Annotated[str, Pattern(r"^[\x00-\xff]+$", "characters 00h..FFh (Latin-1)")]
TelegramType = Literal["BINARY", "CHARACTER", "BYTE", "WORD", "KF", "INTEGER", "REAL", "POINT", "JC_POINT", "TEXT"]
TelegramUnit = Annotated[str, Pattern(r"^(\d+(\.\d+)? )?[^\s\d]\S*$", '"mm" or "0.1 mm" (one count is 0.1 mm)')]


@dataclass(frozen=True, slots=True)
class Rk512:
    """[line.rk512]: the served areas and how addresses are counted."""

    db_address_unit: Literal["word", "byte"] = "word"
    reaction: bool = True
    types: tuple[AreaLetter, ...] = ("D",)
    unknown_block: Annotated[int, Ge(1), Le(255)] = 0x14  # error number for a block that is not listed
    # a job that names one: refuse | ignore | serve | keep (AX-251)
    coordination_flag: Literal["refuse", "ignore", "serve", "keep"] = "refuse"
    end_of_follow_on: Literal["ETX", "ETB"] = "ETX"  # ETX | ETB, as a switch of BUEP64 has it


@dataclass(frozen=True, slots=True)
class Times:
    """[line.times]: single values of the profile overridden, in ms and in either vocabulary; None: as the profile has it (AX-250)."""

    QVZ: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # acknowledgement delay
    ADT: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # the same
    ZVZ: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # character delay
    CDT: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # the same
    BWZ: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # block wait time: for the repeat of a refused block
    reaction: Annotated[int | None, Ge(10), Le(65530), Unit("ms")] = None  # wait for the reaction telegram (VIPA's BWZ)
    pause: Annotated[int | None, Ge(0), Le(65530), Unit("ms")] = None  # before a repeat
    no_buffer: Annotated[int | None, Ge(0), Le(65530), Unit("ms")] = None  # STX while no buffer is free: NAK after
    connect_attempts: Annotated[int | None, Ge(1), Le(255)] = None  # the first one counts
    block_attempts: Annotated[int | None, Ge(1), Le(255)] = None

    @property
    def ack_delay(self) -> int | None:
        """QVZ, whichever way it is called."""
        return self.ADT if self.QVZ is None else self.QVZ

    @property
    def char_delay(self) -> int | None:
        """ZVZ, whichever way it is called."""
        return self.CDT if self.ZVZ is None else self.ZVZ


@dataclass(frozen=True, slots=True)
class Choices:
    """[line.choices]: what the manuals leave open, set otherwise than the profile has it; None: as the profile (AX-221, AX-250)."""

    connect_counter: Literal["per_job", "per_block", "shared"] | None = None
    stray: Literal["silent", "nak_after_quiet", "nak_at_once"] | None = None
    broken_pair: Literal["nak_at_end", "nak_at_once", "drop_dle"] | None = None
    too_long: Literal["nak_at_end", "nak_at_once"] | None = None
    interruption: Literal["ignore", "back_off"] | None = None
    silence_ends: bool | None = None
    yields_to_second_conflict: bool | None = None
    nak_at_start: bool | None = None
    nak_when_giving_up: bool | None = None
    nesting: bool | None = None  # RK512: a command that comes while we wait for a reaction is served


@dataclass(frozen=True, slots=True)
class Supervision:
    """[line.supervision]: when the partner counts as silent and what the axes do then."""

    # 0 (telegrams only): a quiet partner does not count as lost; the loader's default there (AX-195)
    max_silence_ms: Annotated[int, Ge(0), Le(60000), Unit("ms")] = 1000
    life_word: str | None = None  # e.g. DB10.DW31: counts up in every SEND of the PLC
    on_loss: OnLoss = "stop_on_path"  # hold | finish_move | stop_on_path | quick_stop
    restart: Literal["new_command"] = "new_command"


@dataclass(frozen=True, slots=True)
class ProgramUnit:
    """[[line.program]]: a unit that programs of the old controller READ and WRITE on this line (AX-1021)."""

    device: Literal["V24_1", "V24_2", "V24_3", "V24_4"]
    procedure: Literal["3964R", "text", "echo"] = "3964R"  # 8, 5 and 2 of mode 9.1
    format: Annotated[str, Pattern(f"^(|({BAUDS}) [78][NEO][12])$", '"9600 8E1": baud, bits, parity, stop')] = ""  # as the line
    output_timeout_ms: Annotated[int, Ge(0), Le(65535), Unit("ms")] = 10_000  # of a text; 0: not watched
    input_timeout_ms: Annotated[int | None, Ge(1), Le(3_600_000), Unit("ms")] = None  # a READ waits for ever


@dataclass(frozen=True, slots=True)
class Line:
    """[[line]]: a serial line to a PLC or host."""

    name: Name
    port: LinePort
    format: Annotated[str, Pattern(f"^({BAUDS}) [78][NEO][12]$", '"9600 8E1": baud, bits, parity, stop')] = "9600 8E1"
    wiring: str = ""
    protocol: Literal["3964R", "3964"] = "3964R"
    profile: str = "rho3"
    priority: Literal["low", "high"] = "low"
    layer: Annotated[str, Registered("line layers")] = "rk512"
    role: Literal["passive", "active", "both"] = "passive"
    # the rho 3's name for the priority: -1 = low, all else high (worked into priority)
    output_timeout: Annotated[int | None, Ge(-1), Le(65535)] = None
    byte_order: Literal["big", "little"] = "big"
    rk512: Rk512 = Rk512()
    times: Times = Times()
    choices: Choices = Choices()
    supervision: Supervision = Supervision()
    program: tuple[ProgramUnit, ...] = ()

    @property
    def baud(self) -> int:
        """Bits per second out of the frame format."""
        return int(self.format.split()[0])


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a data block; exactly one of `to` (PLC writes) and `from_` (axisgate writes) is set."""

    at: str
    type: NumberForm
    to: str | None = None
    from_: str | None = None
    # "0.1 mm": one count is 0.1 mm
    unit: Annotated[str, Pattern(r"^\d+(\.\d+)?( (mm|deg|%|ms|s))?$", '"0.1 mm", "1 deg", "1 %", "1 ms"')] = "1"
    min: float | None = None
    max: float | None = None
    edge: Literal["rising"] | None = None  # rising: only the 0 -> 1 edge acts
    comment: str = ""

    @property
    def signal(self) -> str:
        """The signal this entry moves, whichever way."""
        return self.to or self.from_ or ""


@dataclass(frozen=True, slots=True)
class Db:
    """[[db]]: a data block of `words` STEP 5 words; `line` is filled in by the loader when the cell has one RK512 line.

    Other kinds than D are served as their type: X extended block; E A M words of bytes; T Z numbers.  With role active or both a block may
    be sent (writer axisgate) or fetched (writer plc) by axisgate, periodically or when it changed (AX-250, AX-252).
    """

    number: Annotated[int, Ge(0), Le(255)]
    words: Annotated[int, Ge(1), Le(256), Unit("words")]
    writer: Name  # plc | axisgate | name of a Modbus server (FC 21, AX-479)
    kind: AreaLetter = "D"  # D X E A M T Z
    line: str = ""
    every_ms: Annotated[int, Ge(0), Le(3_600_000), Unit("ms")] = 0  # our own SEND or FETCH; 0: the partner's business
    on_change: bool = False  # our own SEND when a word has changed
    # "DB20.DW0": where it lies there; "": same number, from its first word on
    at_partner: Annotated[str, Pattern(r"^(D[BX]\d{1,3}\.DW\d{1,3})?$", '"DB20.DW0" or "DX20.DW0"')] = ""
    flag: Annotated[str, Pattern(r"^([MF] ?\d{1,3}\.[0-7])?$", '"M 6.4"')] = ""  # "M 6.4": coordination flag our job names
    comment: str = ""
    entries: tuple[Entry, ...] = ()


@dataclass(frozen=True, slots=True)
class Handshake:
    """[handshake.NAME]: the bits an old program starts a move with, as DBn.Dw.b."""

    pattern: Literal["start-busy-done", "level-ack", "toggle", "strobe-parity", "number-select"]
    start: str = ""  # request or strobe; number-select needs none
    busy: str = ""
    done: str = ""  # acknowledgement of level-ack, toggle, strobe-parity
    refused: str = ""
    parity: Literal["even", "odd"] = "even"  # strobe-parity: ones of code and parity bit together


@dataclass(frozen=True, slots=True)
class TelegramMatch:
    """One entry of `match`: exactly one of hex and text is expected at `byte`."""

    byte: Annotated[int, Ge(0), Le(LONGEST - 1)]
    hex: Hex = ""
    text: Text = ""


@dataclass(frozen=True, slots=True)
class TelegramField:
    """One entry of `fields`: `count` values of `type` from `byte` on, written to a named value."""

    byte: Annotated[int, Ge(0), Le(LONGEST - 1)]
    type: TelegramType  # BINARY CHARACTER BYTE WORD KF INTEGER REAL POINT JC_POINT TEXT
    to: Annotated[str, Pattern(f"^{OWN_NAME}$", "a name of the cell's own, as order.number")]
    count: Annotated[int, Ge(1), Le(LONGEST)] = 1
    unit: TelegramUnit = ""  # "mm", or "0.1 mm": one count is 0.1 mm
    scale: float = 1.0  # value = count x scale
    byte_order: Literal["big", "little"] | None = None  # little | big; None: as the line
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class TelegramPart:
    """One entry of `build`: fixed bytes (hex or text) or a value (type and from)."""

    hex: Hex = ""
    text: Text = ""
    type: TelegramType | Literal[""] = ""
    from_: str = ""
    count: Annotated[int, Ge(1), Le(LONGEST)] = 1
    unit: TelegramUnit = ""
    scale: float = 1.0
    byte_order: Literal["big", "little"] | None = None
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class Telegram:
    """[[telegram]]: a raw 3964R block; match, fields, then: the partner sends it; when, build: we do."""

    line: str
    name: Name
    match: tuple[TelegramMatch, ...] = ()
    length: Annotated[int | None, Ge(1), Le(LONGEST), Unit("bytes")] = None  # bytes; None: any length that holds matches and fields
    fields: tuple[TelegramField, ...] = ()
    then: Annotated[str, Pattern(f"^signal +{OWN_NAME}$", '"signal order.new"')] = ""  # "signal order.new"
    when: Annotated[str, Pattern(r"^(rising|falling|change) +\S+$", '"rising order.done", falling, change')] = ""  # "rising order.done"
    build: tuple[TelegramPart, ...] = ()
