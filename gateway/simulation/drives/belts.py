"""Belts of an emulator process: their settings from the command line, and the command that changes their speed.

{"do": "belt", "belt": 1, "speed": 2500.0}            increments/s; the belt gets there at its acceleration
{"do": "belt", "belt": 1, "silent": true}             its encoder falls silent
"""

import json

from drivers.emulator.io.belts import EmulatedBelt, EmulatedBelts
from gateway.simulation.control_requests import Answer, BadCommandError, Command

FASTEST = 1e9  # increments/s


def belts_from(text: str) -> list[EmulatedBelt]:
    """From a JSON list of tables with the names of EmulatedBelt; raises ValueError."""
    try:
        return [EmulatedBelt(**table) for table in json.loads(text)]
    except TypeError as error:
        raise ValueError(f"--belts {text}: {error}") from None


def carry_out_belt(belts: EmulatedBelts, command: Command) -> Answer:
    """One command; raises BadCommandError."""
    number, speed, silent = command.get("belt"), command.get("speed"), command.get("silent")
    if not isinstance(number, int) or not 1 <= number <= len(belts.all):
        raise BadCommandError(f"belt: {number!r}; expected a whole number 1..{len(belts.all)}")
    if speed is not None and (not isinstance(speed, int | float) or not abs(speed) <= FASTEST):
        raise BadCommandError(f"speed: {speed!r}; expected a number of increments/s, {FASTEST:g} at most")
    if silent is not None and not isinstance(silent, bool):
        raise BadCommandError(f"silent: {silent!r}; expected true or false")
    belt = belts.all[number - 1]
    belt.speed = belt.speed if speed is None else float(speed)
    belt.silent = belt.silent if silent is None else silent
    return {"belts": belts.state()}
