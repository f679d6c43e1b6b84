"""The guest's /dev/ttyS1 and /dev/ttyS2, crossed: a tty driver that is not a pty.  What it cannot show: docs/guest.md."""

import pytest
import serial

pytestmark = pytest.mark.vcan

ONE, OTHER = "/dev/ttyS1", "/dev/ttyS2"
EVERY_BYTE = bytes(range(256))


def test_every_byte_passes_unchanged_in_both_directions() -> None:
    with serial.Serial(ONE, 9600, timeout=5, exclusive=True) as one, serial.Serial(OTHER, 9600, timeout=5, exclusive=True) as other:
        one.write(EVERY_BYTE)
        assert other.read(256) == EVERY_BYTE
        other.write(EVERY_BYTE)
        assert one.read(256) == EVERY_BYTE


def test_a_port_opened_exclusively_is_refused_to_the_next() -> None:
    with serial.Serial(ONE, exclusive=True), pytest.raises(serial.SerialException, match="exclusive"):
        serial.Serial(ONE, exclusive=True)
