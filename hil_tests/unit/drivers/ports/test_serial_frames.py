"""The real serial port's judgement of what its driver says: frame kept, kinds of damage."""

import termios

import pytest

from drivers.ports.serial.device import frame_of, named_damage
from protocols.base.machine import Damage

NONE = dict.fromkeys(Damage, 0)


def counted(**kinds: int) -> dict[Damage, int]:
    return NONE | {Damage[name]: count for name, count in kinds.items()}


@pytest.mark.parametrize(
    ("flags", "speed", "said"),
    [
        (termios.CS8 | termios.PARENB, termios.B9600, "9600 8E1"),
        (termios.CS7 | termios.PARENB | termios.PARODD | termios.CSTOPB, termios.B1200, "1200 7O2"),
        (termios.CS8, termios.B38400, "38400 8N1"),
    ],
)
def test_the_frame_is_read_from_termios(flags: int, speed: int, said: str) -> None:
    assert frame_of([0, 0, flags, 0, speed, speed], 9600) == said


def test_a_speed_termios_has_no_word_for_is_believed() -> None:
    assert frame_of([0, 0, termios.CS8, 0, 0x1000, 0x1000], 250_000) == "250000 8N1"


@pytest.mark.parametrize(
    ("read", "after", "told"),
    [
        ([b"a", Damage.PARITY, b"b"], counted(), [b"a", Damage.PARITY, b"b"]),
        ([b"a", Damage.PARITY, b"b"], counted(PARITY=1), [b"a", Damage.PARITY, b"b"]),
        ([b"a", Damage.PARITY, b"b"], counted(FRAMING=1), [b"a", Damage.FRAMING, b"b"]),
        ([Damage.BREAK], counted(BREAK=1), [Damage.BREAK]),
        ([Damage.BREAK], counted(PARITY=1), [Damage.PARITY]),  # a damaged character 00
        ([Damage.BREAK], counted(FRAMING=1), [Damage.FRAMING]),
        ([b"ab"], counted(OVERRUN=2), [Damage.OVERRUN, b"ab"]),
    ],
)
def test_marks_are_named_by_the_drivers_counters(read: list[bytes | Damage], after: dict[Damage, int], told: list[bytes | Damage]) -> None:
    assert named_damage(read, NONE, after) == told
