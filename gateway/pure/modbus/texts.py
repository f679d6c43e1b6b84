"""Modbus exchanges in words, for people who look at a line.  Source: MODBUS Application Protocol V1.1b3, section 6.

What cannot be decoded is shown raw, never raised: both sides of a line may be wrong.
"""

from dataclasses import dataclass

READS = {1: "coils", 2: "discrete inputs", 3: "holding registers", 4: "input registers"}
NAMES = {
    5: "write coil", 6: "write register", 7: "read exception status", 8: "diagnostics", 11: "comm event counter", 12: "comm event log",
    15: "write coils", 16: "write registers", 17: "report server id", 20: "read file", 21: "write file", 22: "mask write register",
    23: "read and write registers", 24: "read FIFO", 43: "device identification",
}  # fmt: skip
FAULTS = {
    1: "illegal function", 2: "illegal data address", 3: "illegal data value", 4: "device failure", 5: "acknowledge", 6: "busy",
    8: "memory parity error", 10: "gateway path unavailable", 11: "gateway target does not answer",
}  # fmt: skip
MOST = 12  # values shown


@dataclass(frozen=True, slots=True)
class ExchangeText:
    """One exchange: what was asked, what came back, whether it was good."""

    asked: str
    answered: str
    ok: bool


def exchange_text(asked: bytes, answer: bytes) -> ExchangeText:
    """PDUs (function code first), the ends of long ones may be missing; an empty answer is silence."""
    if not asked:
        return ExchangeText("an empty request", _answered(0, asked, answer), False)
    return ExchangeText(_asked(asked), _answered(asked[0], asked, answer), not answer or answer[0] < 0x80)


def _asked(pdu: bytes) -> str:
    function, body = pdu[0], pdu[1:]
    words = [int.from_bytes(body[n : n + 2], "big") for n in range(0, len(body) - 1, 2)]
    name = f"read {READS[function]}" if function in READS else NAMES.get(function, f"function {function}")
    match function, words:
        case 1 | 2 | 3 | 4, [first, count, *_]:
            return f"{name} {_span(first, count)}"
        case 5, [place, value, *_]:
            return f"{name} {place}: {'on' if value == 0xFF00 else 'off' if value == 0 else f'{value:04X}h'}"
        case 6, [place, value, *_]:
            return f"{name} {place}: {value:04X}h"
        case 15, [first, count, *_]:
            return f"{name} {_span(first, count)}: {_bits(body[5:], count)}"
        case 16, [first, count, *_]:
            return f"{name} {_span(first, count)}: {_registers(body[5:])}"
        case 22, [place, keep, put, *_]:
            return f"{name} {place}: and {keep:04X}h, or {put:04X}h"
        case 23, [first, count, to, more, *_]:
            return f"{name}: read {_span(first, count)}, write {_span(to, more)}: {_registers(body[9:])}"
        case _:
            return name


def _answered(function: int, asked: bytes, answer: bytes) -> str:
    if not answer:
        return "no answer"
    if answer[0] >= 0x80:
        code = answer[1] if len(answer) > 1 else 0
        return f"exception {code:02d} {FAULTS.get(code, 'unknown')}"
    if function in (1, 2) and len(asked) >= 5:
        return _bits(answer[2:], int.from_bytes(asked[3:5], "big"))
    return _registers(answer[2:]) if function in (3, 4, 23) else "done"


def _span(first: int, count: int) -> str:
    return f"{first}" if count == 1 else f"{first}..{first + count - 1}"


def _bits(data: bytes, count: int) -> str:
    """Lowest first, as the addresses go."""
    shown = "".join(str(data[n >> 3] >> (n & 7) & 1) for n in range(min(count, 8 * len(data), 8 * MOST)))
    return " ".join(shown[n : n + 8] for n in range(0, len(shown), 8)) + (" .." if count > len(shown) else "")


def _registers(data: bytes) -> str:
    values = [data[n : n + 2].hex().upper() for n in range(0, len(data) - 1, 2)]
    return " ".join(values[:MOST]) + (" .." if len(values) > MOST else "")
