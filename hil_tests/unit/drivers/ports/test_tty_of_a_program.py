"""A pty opened by its own name, as a terminal: what was written to it belongs to the program at its far end."""

import os
import select
import termios
from collections.abc import Iterator

import pytest

from drivers.ports.serial.device import SerialPort
from drivers.ports.serial.line_format import parse_format

FORMAT = parse_format("9600 8N1")


@pytest.fixture
def program() -> Iterator[tuple[int, str]]:
    """Far end and name of a pty that stays open, whoever comes and goes."""
    master, slave = os.openpty()
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_the_last_characters_of_one_user_are_not_lost_when_the_next_one_opens_it(program: tuple[int, str]) -> None:
    """The DLE to a reaction got lost when the next tool came before the station had read it: it sent the reaction again, and that was taken
    for the answer to the next command."""
    master, path = program
    first = SerialPort(path, FORMAT)
    said = b"\x10" * first.write(b"\x10" * 20_000)  # more than the kernel hands on before the far end reads: it hands on later, or not
    first.close()
    second = SerialPort(path, FORMAT)
    heard = b""
    while select.select([master], [], [], 0.2)[0]:
        heard += os.read(master, 4096)
    assert len(heard) == len(said) > 4096
    second.close()


def test_what_came_before_it_was_opened_is_not_for_us(program: tuple[int, str]) -> None:
    master, path = program
    settings = termios.tcgetattr(master)
    settings[3] &= ~(termios.ICANON | termios.ECHO)
    termios.tcsetattr(master, termios.TCSANOW, settings)
    os.write(master, b"old")
    port = SerialPort(path, FORMAT)
    assert port.read() == []
    os.write(master, b"new")
    assert port.read() == [b"new"]
    port.close()
