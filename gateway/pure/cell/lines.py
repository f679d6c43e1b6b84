"""[[line]], [[db]], [handshake.NAME] and [[telegram]] of a cell: what a PLC or host is reached by.  Shapes: users.md 3.4."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Rk512:
    """[line.rk512]: what is served and how addresses are counted."""

    db_address_unit: str = "word"  # word | byte
    reaction: bool = True
    types: tuple[str, ...] = ("D",)
    unknown_block: int = 0x14  # error number for a block that is not listed
    coordination_flag: str = "refuse"  # a job that names one: refuse | ignore | serve | keep (AX-251)
    end_of_follow_on: str = "ETX"  # ETX | ETB, as a switch of BUEP64 has it


@dataclass(frozen=True, slots=True)
class Times:
    """[line.times]: single values of the profile overridden, in ms and in either vocabulary; None: as the profile has it (AX-250)."""

    QVZ: int | None = None  # acknowledgement delay
    ADT: int | None = None  # the same
    ZVZ: int | None = None  # character delay
    CDT: int | None = None  # the same
    BWZ: int | None = None  # block wait time: for the repeat of a refused block
    reaction: int | None = None  # wait for the reaction telegram (VIPA's BWZ)
    pause: int | None = None  # before a repeat
    no_buffer: int | None = None  # STX while no buffer is free: NAK after
    connect_attempts: int | None = None  # the first one counts
    block_attempts: int | None = None

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

    connect_counter: str | None = None  # per_job | per_block | shared
    stray: str | None = None  # silent | nak_after_quiet | nak_at_once
    broken_pair: str | None = None  # nak_at_end | nak_at_once | drop_dle
    too_long: str | None = None  # nak_at_end | nak_at_once
    interruption: str | None = None  # ignore | back_off
    silence_ends: bool | None = None
    yields_to_second_conflict: bool | None = None
    nak_at_start: bool | None = None
    nak_when_giving_up: bool | None = None
    nesting: bool | None = None  # RK512: a command that comes while we wait for a reaction is served


@dataclass(frozen=True, slots=True)
class Supervision:
    """[line.supervision]: when the partner counts as silent and what the axes do then."""

    max_silence_ms: int = 1000  # 0 (telegrams only): a quiet partner is no loss; the loader's default there (AX-195)
    life_word: str | None = None  # e.g. DB10.DW31: counts up in every SEND of the PLC
    on_loss: str = "stop_on_path"  # hold | finish_move | stop_on_path | quick_stop
    restart: str = "new_command"


@dataclass(frozen=True, slots=True)
class Line:
    """[[line]]: a serial line to a PLC or host."""

    name: str
    port: str
    format: str = "9600 8E1"
    wiring: str = ""
    protocol: str = "3964R"
    profile: str = "rho3"
    priority: str = "low"
    layer: str = "rk512"  # rk512 | telegrams | buep64 | program
    role: str = "passive"  # passive | active | both
    output_timeout: int | None = None  # the rho 3's name for the priority: -1 = low, all else high (worked into priority)
    byte_order: str = "big"
    rk512: Rk512 = Rk512()
    times: Times = Times()
    choices: Choices = Choices()
    supervision: Supervision = Supervision()

    @property
    def baud(self) -> int:
        """Bits per second out of the frame format."""
        return int(self.format.split()[0])


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a data block; exactly one of `to` (PLC writes) and `from_` (axisgate writes) is set."""

    at: str
    type: str  # bit KF DH KH KM KY KC KT KZ KG REAL BCD
    to: str | None = None
    from_: str | None = None
    unit: str = "1"  # "0.1 mm": one count is 0.1 mm
    min: float | None = None
    max: float | None = None
    edge: str | None = None  # rising: only the 0 -> 1 edge acts
    comment: str = ""

    @property
    def signal(self) -> str:
        """The signal this entry moves, whichever way."""
        return self.to or self.from_ or ""


@dataclass(frozen=True, slots=True)
class Db:
    """[[db]]: a data block of `words` STEP 5 words; `line` is filled in by the loader when the cell has one RK512 line.

    Other kinds than D are served as their type: X extended block; E A M words of bytes; T Z numbers.  With role active or both a block may
    be sent (writer axisgate) or fetched (writer plc) by us, every so often or when it changed (AX-250, AX-252).
    """

    number: int
    words: int
    writer: str  # plc | axisgate | name of a Modbus server (FC 21, AX-479)
    kind: str = "D"  # D X E A M T Z
    line: str = ""
    every_ms: int = 0  # our own SEND or FETCH; 0: the partner's business
    on_change: bool = False  # our own SEND when a word has changed
    at_partner: str = ""  # "DB20.DW0": where it lies there; "": same number, from its first word on
    flag: str = ""  # "M 6.4": coordination flag our job names
    comment: str = ""
    entries: tuple[Entry, ...] = ()


@dataclass(frozen=True, slots=True)
class Handshake:
    """[handshake.NAME]: the bits an old program starts a move with, as DBn.Dw.b."""

    pattern: str
    start: str = ""  # request or strobe; number-select needs none
    busy: str = ""
    done: str = ""  # acknowledgement of level-ack, toggle, strobe-parity
    refused: str = ""
    parity: str = "even"  # strobe-parity: ones of code and parity bit together


@dataclass(frozen=True, slots=True)
class TelegramMatch:
    """One entry of `match`: exactly one of hex and text stands at `byte`."""

    byte: int
    hex: str = ""
    text: str = ""


@dataclass(frozen=True, slots=True)
class TelegramField:
    """One entry of `fields`: `count` values of `type` from `byte` on, written to a named value."""

    byte: int
    type: str  # BINARY CHARACTER BYTE WORD KF INTEGER REAL POINT JC_POINT TEXT
    to: str
    count: int = 1
    unit: str = ""  # "mm", or "0.1 mm": one count is 0.1 mm
    scale: float = 1.0  # value = count x scale
    byte_order: str | None = None  # little | big; None: as the line
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class TelegramPart:
    """One entry of `build`: fixed bytes (hex or text) or a value (type and from)."""

    hex: str = ""
    text: str = ""
    type: str = ""
    from_: str = ""
    count: int = 1
    unit: str = ""
    scale: float = 1.0
    byte_order: str | None = None
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class Telegram:
    """[[telegram]]: a raw 3964R block; match, fields, then: the partner sends it; when, build: we do."""

    line: str
    name: str
    match: tuple[TelegramMatch, ...] = ()
    length: int | None = None  # bytes; None: any length that holds matches and fields
    fields: tuple[TelegramField, ...] = ()
    then: str = ""  # "signal order.new"
    when: str = ""  # "rising order.done"
    build: tuple[TelegramPart, ...] = ()
