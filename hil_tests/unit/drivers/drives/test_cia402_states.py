"""IEC 61800-7-201, finite state automaton: our table and the emulated drive's, each written for itself, against the standard's own rows."""

import pytest

from drivers.drives.cia402_states import MOVES, Command, State, next_command, state_of
from drivers.emulator.cia402 import states as theirs

# The standard's table "statusword" as printed: bits 6, 5, 3, 2, 1, 0; x = whatever
PRINTED = {
    State.NOT_READY: "0x0000",
    State.DISABLED: "1x0000",
    State.READY: "010001",
    State.SWITCHED_ON: "010011",
    State.ENABLED: "010111",
    State.QUICK_STOP: "000111",
    State.REACTING: "0x1111",
    State.FAULT: "0x1000",
}
BITS = (6, 5, 3, 2, 1, 0)
NAMES = {State.SWITCHED_ON: "ON", State.REACTING: "REACTION"}


def fits(statusword: int, row: str) -> bool:
    return all(mark == "x" or statusword >> bit & 1 == int(mark) for mark, bit in zip(row, BITS, strict=True))


def test_every_statusword_means_what_the_printed_table_says() -> None:
    for statusword in range(65536):
        rows = [state for state, row in PRINTED.items() if fits(statusword, row)]
        assert len(rows) <= 1
        assert state_of(statusword) is (rows[0] if rows else None)


def test_what_the_emulated_drive_shows_is_read_as_the_state_it_is_in() -> None:
    ours = {state_of(word): state.name for state, word in theirs.STATUS.items()}
    assert ours == {state: NAMES.get(state, state.name) for state in State}


def test_both_sides_know_the_same_transitions() -> None:
    names = {state: theirs.State[NAMES.get(state, state.name)] for state in State}
    for (before, command), after in MOVES.items():
        if command is Command.RESET:
            continue
        heard = theirs.command_of(command.value)
        assert theirs.TRANSITIONS[names[before], heard][1] is names[after], (before, command)


@pytest.mark.parametrize(
    ("start", "way"),
    [
        (State.DISABLED, [Command.SHUTDOWN, Command.SWITCH_ON, Command.ENABLE]),
        (State.FAULT, [Command.RESET, Command.SHUTDOWN, Command.SWITCH_ON, Command.ENABLE]),
        (State.QUICK_STOP, [Command.DISABLE_VOLTAGE, Command.SHUTDOWN, Command.SWITCH_ON, Command.ENABLE]),
    ],
)
def test_the_way_on_is_found_in_the_table(start: State, way: list[Command]) -> None:
    state, taken = start, []
    while (command := next_command(state, State.ENABLED)) is not None:
        taken.append(command)
        state = MOVES[state, command]
    assert taken == way and state is State.ENABLED


def test_from_not_ready_no_command_leads_anywhere() -> None:
    assert next_command(State.NOT_READY, State.ENABLED) is None
