"""`axisgate line send` and `fetch`: data words of a passive RK512 partner, in the number types of STEP 5."""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.image.addresses import AddressFault, DataBit, DataWord, Part, parse
from protocols.base.errors import DecodeError, EncodeError
from protocols.base.step5 import Step5Type, Value, decode, encode

TELEGRAM_WORDS = 64  # 128 bytes
TYPES = {kind.value.upper(): kind for kind in Step5Type}


class BadInput(ValueError):
    """The command line is wrong; the text names the expected form."""


@dataclass(frozen=True, slots=True)
class Word:
    """One decoded place: address, type, value (or why none), bytes."""

    address: str
    kind: str
    value: Value | None
    text: str
    data: bytes


def place(text: str) -> tuple[int, int]:
    """Block and word of an address such as DB10.DW2 or DB10.DD4."""
    try:
        address = parse(text)
    except AddressFault as fault:
        of_a_block = text.strip().upper().startswith("DB") and "." in text
        raise BadInput(str(fault) if of_a_block else f"{text!r}: a data word expected, such as DB10.DW2 or DB10.DD2") from fault
    if isinstance(address, DataBit) or (isinstance(address, DataWord) and address.part in (Part.LEFT, Part.RIGHT)):
        raise BadInput(f"{text}: RK512 moves whole data words; DB10.DW2 or DB10.DD2 expected")
    if not isinstance(address, DataWord):
        raise BadInput(f"{text}: a data word expected, such as DB10.DW2")
    return address.db, address.word


def reachable(word: int, words: int) -> None:
    """BadInput where a telegram of the job would begin beyond DW 255: byte 6 of its header has no number for it."""
    most = (255 - word) // TELEGRAM_WORDS * TELEGRAM_WORDS + TELEGRAM_WORDS
    if words > most:
        raise BadInput(
            f"{words} data words from DW{word} on: at most {most}; a telegram begins at DW 0..255 and has {TELEGRAM_WORDS} words"
        )


def kinds(text: str) -> list[Step5Type]:
    """`KF` or `KF,KH,KG`; BadInput lists the types."""
    found = [TYPES.get(name.strip().upper()) for name in text.split(",")]
    if None in found:
        raise BadInput(f"type {text}: {', '.join(TYPES)} expected, one or several with commas; an S5 float is KG, an IEEE one REAL")
    return [kind for kind in found if kind is not None]


def number(kind: Step5Type, text: str) -> Value:
    """Operator input for a type: 1200, -3, 0A1Fh or 0x0A1F (KH, KM), 12,34 (KY, KT), AB (KC), 1200.5 (KG, REAL)."""
    try:
        match kind:
            case Step5Type.KC:
                return text
            case Step5Type.KG | Step5Type.REAL:
                return float(text.replace(",", "."))
            case Step5Type.KY | Step5Type.KT:
                left, _, right = text.replace(".", ",").partition(",")
                return int(left), int(right)
            case Step5Type.KH:
                return int(text.rstrip("hH").removeprefix("0x"), 16)
            case Step5Type.KM:
                return int(text.removeprefix("0b"), 2) if set(text.removeprefix("0b")) <= set("01") else int(text.rstrip("hH"), 16)
            case Step5Type.BIT:
                return bool(int(text))
            case _:
                return int(text, 0)
    except ValueError as error:
        raise BadInput(f"{text!r} is not a {kind.value} value: {EXPECTED.get(kind, 'a whole number expected')}") from error


EXPECTED = {
    Step5Type.KY: "two numbers expected, as in 12,34",
    Step5Type.KT: "count and time base expected, as in 500,1",
    Step5Type.KH: "hexadecimal digits expected, as in 0A1F",
    Step5Type.KM: "16 binary digits expected",
    Step5Type.KG: "a number expected, as in 1200.5",
    Step5Type.REAL: "a number expected, as in 1200.5",
}


def encoded(types: Sequence[Step5Type], values: Sequence[str]) -> bytes:
    """The bytes of the values; the last type holds for all values that remain."""
    if not values:
        raise BadInput("no value to send")
    data = b""
    for at, text in enumerate(values):
        kind = types[min(at, len(types) - 1)]
        try:
            data += encode(kind, number(kind, text))
        except EncodeError as error:
            raise BadInput(str(error)) from error
    return data


def words_needed(types: Sequence[Step5Type], count: int) -> int:
    """Data words of `count` values; the last type holds for all that remain."""
    return sum(types[min(at, len(types) - 1)].size for at in range(count)) // 2


def decoded(types: Sequence[Step5Type], db: int, word: int, data: bytes) -> list[Word]:
    """The values of fetched words, in order."""
    found: list[Word] = []
    at = 0
    while at < len(data):
        kind = types[min(len(found), len(types) - 1)]
        piece = data[at : at + kind.size]
        name = f"DB{db}.{'DD' if kind.size == 4 else 'DW'}{word + at // 2}"
        found.append(_word(name, kind, piece))
        at += kind.size
    return found


def _word(name: str, kind: Step5Type, piece: bytes) -> Word:
    try:
        value = decode(kind, piece)
    except DecodeError as error:
        return Word(name, kind.value, None, f"no {kind.value}: {error}", piece)
    return Word(name, kind.value, value, shown(kind, value), piece)


def shown(kind: Step5Type, value: Value) -> str:
    """A value as it is written for its type."""
    if kind is Step5Type.KH and isinstance(value, int):
        return f"{value:04X}"
    if kind is Step5Type.KM and isinstance(value, int):
        return f"{value:016b}"
    if isinstance(value, tuple):
        return f"{value[0]},{value[1]}"
    return f"{value:.7g}" if isinstance(value, float) else repr(value) if isinstance(value, str) else str(value)
