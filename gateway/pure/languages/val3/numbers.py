"""Instructions on numbers and bit fields.  Source: VAL 3 reference 3.2-3.3, L1527-2033; doubt D05."""

import math
import struct

from gateway.pure.languages.val3.errors import Rte

Place = tuple[list[object], int]
FORMATS = {
    "-1": "b",
    "1": "B",
    "-2l": "<h",
    "-2b": ">h",
    "2l": "<H",
    "2b": ">H",
    "-4l": "<i",
    "-4b": ">i",
    "4l": "<I",
    "4b": ">I",
    "4.0l": "<f",
    "4.0b": ">f",
    "8.0l": "<d",
    "8.0b": ">d",
}


def f_sin(angle: float) -> float:
    """Degrees; exact at multiples of 30 deg where the sine is."""
    return _neat(math.sin(math.radians(angle)))


def f_cos(angle: float) -> float:
    """Degrees."""
    return _neat(math.cos(math.radians(angle)))


def f_tan(angle: float) -> float:
    """Degrees."""
    return _neat(math.tan(math.radians(angle)))


def _neat(value: float) -> float:
    """Round to about 14 digits (L1531), which removes rounding errors of the conversion."""
    return round(value, 15) if abs(value) < 1e3 else value


def f_asin(value: float) -> float:
    """-90..90; 11."""
    return round(math.degrees(math.asin(value)), 13)


def f_acos(value: float) -> float:
    """0..180; 11."""
    return round(math.degrees(math.acos(value)), 13)


def f_atan(value: float) -> float:
    """-90..90."""
    return round(math.degrees(math.atan(value)), 13)


def f_abs(value: float) -> float:
    """Magnitude."""
    return abs(value)


def f_sqrt(value: float) -> float:
    """11 below 0."""
    return math.sqrt(value)


def f_exp(value: float) -> float:
    """11 where it is too large."""
    return math.exp(value)


def f_power(base: float, exponent: float) -> float:
    """11 for a base that is not above 0, and for a result too large."""
    if base <= 0:
        raise Rte(11, f"power({base:g}, {exponent:g})")
    return math.pow(base, exponent)


def f_ln(value: float) -> float:
    """11 for 0 and below."""
    return math.log(value)


def f_log(value: float) -> float:
    """Base 10; 11."""
    return math.log10(value)


def f_round_up(value: float) -> float:
    """Ceiling."""
    return float(math.ceil(value))


def f_round_down(value: float) -> float:
    """Floor."""
    return float(math.floor(value))


def f_round(value: float) -> float:
    """Nearest, halves up."""
    return float(math.floor(value + 0.5))


def f_min(first: float, second: float) -> float:
    """The smaller one."""
    return min(first, second)


def f_max(first: float, second: float) -> float:
    """The larger one."""
    return max(first, second)


def f_limit(value: float, low: float, high: float) -> float:
    """Clamped."""
    return min(max(value, low), high)


def f_sel(condition: bool, first: float, second: float) -> float:
    """true: the first value."""
    return first if condition else second


def add_on(name: str) -> bool:
    """A condition with a call of an add-on: 250."""
    raise Rte(250, name)


def modulo(first: float, second: float) -> float:
    """%: the sign of the left operand; 10."""
    if second == 0:
        raise Rte(10, "modulo 0")
    return math.fmod(first, second)


def step_of(value: float) -> float:
    """The step of a for; 70 for 0 (D02)."""
    if value == 0:
        raise Rte(70, "step 0")
    return value


def bits(value: float) -> int:
    """A number as 32 bits."""
    return math.floor(value + 0.5) & 0xFFFFFFFF


def f_b_not(value: float) -> float:
    """32 bits inverted."""
    return float(~bits(value) & 0xFFFFFFFF)


def f_b_and(first: float, second: float) -> float:
    """And."""
    return float(bits(first) & bits(second))


def f_b_or(first: float, second: float) -> float:
    """Or."""
    return float(bits(first) | bits(second))


def f_b_xor(first: float, second: float) -> float:
    """Xor."""
    return float(bits(first) ^ bits(second))


def _format(text: str) -> struct.Struct:
    if text not in FORMATS:
        raise Rte(70, f"format {text!r}; there are {', '.join(FORMATS)}")
    return struct.Struct(FORMATS[text])


def f_to_binary(values: Place, size: float, form: str, target: Place) -> float:
    """The number of bytes; 70 for an unknown format, too few values or too small a target."""
    packer, count = _format(form), math.floor(size + 0.5)
    (numbers, first), (data, start) = values, target
    if not 0 <= count <= len(numbers) - first:
        raise Rte(70, f"{count} values of {len(numbers) - first}")
    if count * packer.size > len(data) - start:
        raise Rte(70, f"{count * packer.size} bytes into {len(data) - start}")
    made = b"".join(_packed(packer, form, number) for number in numbers[first : first + count])
    data[start : start + len(made)] = [float(byte) for byte in made]
    return float(len(made))


def f_to_binary_of_what_is_there(values: Place, size: float, form: str, target: Place) -> float:
    """As f_to_binary; more values than the array has are not looked for (s8)."""
    return f_to_binary(values, min(size, float(len(values[0]) - values[1])), form, target)


def _packed(packer: struct.Struct, form: str, number: object) -> bytes:
    assert isinstance(number, float)
    if "." in form:
        try:
            return packer.pack(number)
        except OverflowError:
            return packer.pack(math.copysign(math.inf, number))
    whole = math.floor(number + 0.5) & ((1 << 8 * packer.size) - 1)
    raw = whole.to_bytes(packer.size, "big" if form.endswith("b") else "little")
    return raw


def f_from_binary(source: Place, size: float, form: str, target: Place) -> float:
    """The number of values; minus those converted before the first damaged one."""
    packer, count = _format(form), math.floor(size + 0.5)
    (data, start), (values, first) = source, target
    if not 0 <= count <= len(data) - start:
        raise Rte(70, f"{count} bytes of {len(data) - start}")
    amount = count // packer.size
    if amount > len(values) - first:
        raise Rte(70, f"{amount} values into {len(values) - first}")
    for at in range(amount):
        chunk = data[start + at * packer.size : start + (at + 1) * packer.size]
        if not all(isinstance(byte, float) and 0 <= byte <= 255 and byte == int(byte) for byte in chunk):
            return float(-at)
        (value,) = packer.unpack(bytes(int(byte) for byte in chunk if isinstance(byte, float)))
        if not math.isfinite(value):
            return float(-at)
        values[first + at] = float(value)
    return float(amount)
