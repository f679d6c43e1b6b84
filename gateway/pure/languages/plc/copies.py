"""The copy of a program that a PLC runs, as bytes: what a process that was killed comes back with."""

import json
import zlib

from gateway.pure.languages.plc.commands import Code, Command, Operand, Program, Routine
from gateway.pure.languages.plc.messages import FUNCTION_CODE, IDENTIFICATION

DIGEST = 4  # bytes of the check sum


class DamagedCopy(Exception):
    """The copy cannot run; `number` is that of the PLC error."""

    def __init__(self, number: int) -> None:
        super().__init__(f"PLC error {number}: the copy of the PLC program is damaged; start the PLC again")
        self.number = number


def to_bytes(program: Program) -> bytes:
    """The compiled form with its check sum."""
    routines = [[name, routine.last, [_row(command) for command in routine.commands]] for name, routine in program.routines.items()]
    data = json.dumps([program.start, routines], separators=(",", ":")).encode()
    return _sum(data) + data


def from_bytes(data: bytes) -> Program:
    """The reverse.  DamagedCopy 7004: the check sum is wrong; 7003: a function code is unknown."""
    if _sum(data[DIGEST:]) != data[:DIGEST]:
        raise DamagedCopy(IDENTIFICATION)
    try:
        start, routines = json.loads(data[DIGEST:])
        return Program(start, {name: Routine(name, tuple(_command(*row) for row in rows), last) for name, last, rows in routines})
    except (ValueError, TypeError) as error:
        raise DamagedCopy(FUNCTION_CODE) from error


def _sum(data: bytes) -> bytes:
    return zlib.crc32(data).to_bytes(DIGEST, "little")


def _row(command: Command) -> list[str | int]:
    operand = "" if command.operand is Operand.BIT else command.operand.value
    return [command.code.value, command.line, operand, command.byte, command.mask, command.cell, command.number, command.name]


def _command(code: str, line: int, operand: str, byte: int, mask: int, cell: int, number: int, name: str) -> Command:
    return Command(Code(code), line, Operand(operand) if operand else Operand.BIT, byte, mask, cell, number, name)
