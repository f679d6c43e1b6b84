"""The edge of [[line]], [[db]], [handshake.NAME] and [[telegram]]: pydantic models of gateway.pure.cell.lines."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from gateway.files.table_model import BAUDS, Name, OnLoss, Table, unit

STEP5_TYPES = ("bit", "KF", "DH", "KH", "KM", "KY", "KC", "KT", "KZ", "KG", "REAL", "BCD")
LONGEST = 4000  # bytes of a block at the station that takes most; each profile has its own limit, which `check` knows
ENGLISH = {"I": "E", "Q": "A", "F": "M", "C": "Z", "DB": "D", "DX": "X"}  # S7 and English STEP 5; users.md 3.2


def german(letter: object) -> object:
    """I Q F C are E A M Z."""
    return ENGLISH.get(letter, letter) if isinstance(letter, str) else letter


AreaLetter = Annotated[Literal["D", "X", "E", "A", "M", "T", "Z"], BeforeValidator(german)]


class Rk512(Table):
    db_address_unit: Literal["word", "byte"] = "word"
    reaction: bool = True
    types: list[AreaLetter] = ["D"]
    unknown_block: int = Field(default=0x14, ge=1, le=255)
    coordination_flag: Literal["refuse", "ignore", "serve", "keep"] = "refuse"
    end_of_follow_on: Literal["ETX", "ETB"] = "ETX"


def ms_range(low: int = 0, high: int = 65530) -> Any:
    """An optional time in ms."""
    return Field(default=None, ge=low, le=high, json_schema_extra=unit("ms"))


class Times(Table):
    QVZ: int | None = ms_range(10)
    ADT: int | None = ms_range(10)
    ZVZ: int | None = ms_range(10)
    CDT: int | None = ms_range(10)
    BWZ: int | None = ms_range(10)
    reaction: int | None = ms_range(10)
    pause: int | None = ms_range()
    no_buffer: int | None = ms_range()
    connect_attempts: int | None = Field(default=None, ge=1, le=255)
    block_attempts: int | None = Field(default=None, ge=1, le=255)


class Choices(Table):
    connect_counter: Literal["per_job", "per_block", "shared"] | None = None
    stray: Literal["silent", "nak_after_quiet", "nak_at_once"] | None = None
    broken_pair: Literal["nak_at_end", "nak_at_once", "drop_dle"] | None = None
    too_long: Literal["nak_at_end", "nak_at_once"] | None = None
    interruption: Literal["ignore", "back_off"] | None = None
    silence_ends: bool | None = None
    yields_to_second_conflict: bool | None = None
    nak_at_start: bool | None = None
    nak_when_giving_up: bool | None = None
    nesting: bool | None = None


class Supervision(Table):
    max_silence_ms: int = Field(default=1000, ge=0, le=60000, json_schema_extra=unit("ms"))
    life_word: str | None = None
    on_loss: OnLoss = "stop_on_path"
    restart: Literal["new_command"] = "new_command"


class Line(Table):
    name: Name
    port: str = Field(
        pattern=r"^(sim|/dev/\S+|COM\d+|pty:\S+|tcp://\S+:\d+|rfc2217://\S+:\d+)$",
        json_schema_extra={"allowed": "sim | /dev/... | COM5 | pty:/path | tcp://host:port | rfc2217://host:port"},
    )
    format: str = Field(
        default="9600 8E1", pattern=rf"^({BAUDS}) [78][NEO][12]$", json_schema_extra={"allowed": '"9600 8E1": baud, bits, parity, stop'}
    )
    wiring: str = ""
    protocol: Literal["3964R", "3964"] = "3964R"
    profile: str = "rho3"
    priority: Literal["low", "high"] = "low"
    layer: Literal["rk512", "telegrams", "buep64", "program"] = "rk512"
    role: Literal["passive", "active", "both"] = "passive"
    output_timeout: int | None = Field(default=None, ge=-1, le=65535)
    byte_order: Literal["big", "little"] = "big"
    rk512: Rk512 = Rk512()
    times: Times = Times()
    choices: Choices = Choices()
    supervision: Supervision = Supervision()


class Entry(Table):
    at: str
    type: Literal["bit", "KF", "DH", "KH", "KM", "KY", "KC", "KT", "KZ", "KG", "REAL", "BCD"]
    to: str | None = None
    from_: str | None = Field(default=None, alias="from")
    unit: str = Field(
        default="1", pattern=r"^\d+(\.\d+)?( (mm|deg|%|ms|s))?$", json_schema_extra={"allowed": '"0.1 mm", "1 deg", "1 %", "1 ms"'}
    )
    min: float | None = None
    max: float | None = None
    edge: Literal["rising"] | None = None
    comment: str = ""


class Db(Table):
    number: int = Field(ge=0, le=255)
    words: int = Field(ge=1, le=256, json_schema_extra=unit("words"))
    writer: Name
    kind: AreaLetter = "D"
    line: str = ""
    every_ms: int = Field(default=0, ge=0, le=3_600_000, json_schema_extra=unit("ms"))
    on_change: bool = False
    at_partner: str = Field(default="", pattern=r"^(D[BX]\d{1,3}\.DW\d{1,3})?$", json_schema_extra={"allowed": '"DB20.DW0" or "DX20.DW0"'})
    flag: str = Field(default="", pattern=r"^([MF] ?\d{1,3}\.[0-7])?$", json_schema_extra={"allowed": '"M 6.4"'})
    comment: str = ""
    entries: list[Entry] = []


class Handshake(Table):
    pattern: Literal["start-busy-done", "level-ack", "toggle", "strobe-parity", "number-select"]
    start: str = ""
    busy: str = ""
    done: str = ""
    refused: str = ""
    parity: Literal["even", "odd"] = "even"


Hex = Annotated[str, Field(pattern=r"^\s*([0-9A-Fa-f]{2}\s*)+$", json_schema_extra={"allowed": '"00 4F", two hex digits a byte'})]
Text = Annotated[str, Field(pattern=r"^[\x00-\xff]+$", json_schema_extra={"allowed": "characters 00h..FFh (Latin-1)"})]
TelegramType = Literal["BINARY", "CHARACTER", "BYTE", "WORD", "KF", "INTEGER", "REAL", "POINT", "JC_POINT", "TEXT"]
TelegramUnit = Annotated[
    str, Field(pattern=r"^(\d+(\.\d+)? )?[^\s\d]\S*$", json_schema_extra={"allowed": '"mm" or "0.1 mm" (one count is 0.1 mm)'})
]
OwnName = r"[a-z]\w*(\.\w+)+"  # as gateway.pure.image.addresses reads it


class TelegramMatch(Table):
    byte: int = Field(ge=0, le=LONGEST - 1)
    hex: Hex = ""
    text: Text = ""


class TelegramField(Table):
    byte: int = Field(ge=0, le=LONGEST - 1)
    type: TelegramType
    to: str = Field(pattern=rf"^{OwnName}$", json_schema_extra={"allowed": "a name of the cell's own, as order.number"})
    count: int = Field(default=1, ge=1, le=LONGEST)
    unit: TelegramUnit = ""
    scale: float = 1.0
    byte_order: Literal["big", "little"] | None = None
    min: float | None = None
    max: float | None = None


class TelegramPart(Table):
    hex: Hex = ""
    text: Text = ""
    type: TelegramType | Literal[""] = ""
    from_: str = Field(default="", alias="from")
    count: int = Field(default=1, ge=1, le=LONGEST)
    unit: TelegramUnit = ""
    scale: float = 1.0
    byte_order: Literal["big", "little"] | None = None
    min: float | None = None
    max: float | None = None


class Telegram(Table):
    line: str
    name: Name
    match: list[TelegramMatch] = []
    length: int | None = Field(default=None, ge=1, le=LONGEST, json_schema_extra=unit("bytes"))
    fields: list[TelegramField] = []
    then: str = Field(default="", pattern=rf"^signal +{OwnName}$", json_schema_extra={"allowed": '"signal order.new"'})
    when: str = Field(
        default="", pattern=r"^(rising|falling|change) +\S+$", json_schema_extra={"allowed": '"rising order.done", falling, change'}
    )
    build: list[TelegramPart] = []
