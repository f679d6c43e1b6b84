"""mbpoll at the running product, `axisgate run demo --sim`: RC signals by number, who may write, the command block (AX-011, AX-012)."""

import time
from collections.abc import Callable, Iterator

import pytest

from hil_tests.lab.partners.mbpoll import mbpoll, values_of
from hil_tests.lab.partners.plc2 import DONE, REQUEST
from hil_tests.lab.running.cell_running import CellRun, running_cell

pytestmark = pytest.mark.mbpoll

COILS, DISCRETES, INPUTS, HOLDINGS = "0", "1", "3", "4"  # mbpoll's -t
BLOCK = 1000  # command block in the holding registers, status block in the input registers
RESYNCHRONISED = 20
SOURCE_OF_PLC2 = 2
ENABLING = (1, 1, 1, 1, 1)  # coils 24..28


@pytest.fixture(scope="module")
def run() -> Iterator[CellRun]:
    with running_cell("demo", "mbpoll", plc=False) as run:
        yield run


def read(run: CellRun, table: str, first: int, count: int) -> list[int]:
    code, text = mbpoll(run.port, "-0", "-t", table, "-r", str(first), "-c", str(count))
    assert code == 0, text
    found = values_of(text)
    assert list(found) == list(range(first, first + count))
    return list(found.values())


def write(run: CellRun, table: str, first: int, *values: int) -> tuple[int, str]:
    return mbpoll(run.port, "-0", "-t", table, "-r", str(first), values=values)


def within(seconds: float, holds: Callable[[], bool]) -> bool:
    until = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > until:
            return False
    return True


def test_a_coil_of_the_sources_own_byte_is_an_rc_input(run: CellRun) -> None:
    """Bit N is coil N; byte 3 is the low byte of holding register 1."""
    assert write(run, COILS, 24, 1)[0] == 0
    assert read(run, COILS, 24, 5) == [1, 0, 0, 0, 0]
    assert write(run, COILS, 24, *ENABLING)[0] == 0
    assert read(run, COILS, 16, 16) == [0] * 8 + [1] * 5 + [0] * 3
    assert read(run, HOLDINGS, 0, 3) == [0, 0x1F, 0]


@pytest.mark.parametrize("coil", [0, 23, 32, 400])
def test_a_byte_nobody_owns_is_not_for_writing(run: CellRun, coil: int) -> None:
    code, text = write(run, COILS, coil, 1)
    assert code != 0 and "Illegal data address" in text
    assert read(run, COILS, coil, 1) == [0]


def test_a_write_across_the_edge_of_its_byte_is_refused_whole(run: CellRun) -> None:
    assert write(run, COILS, 24, *ENABLING)[0] == 0
    code, text = write(run, COILS, 22, *[0] * 8)
    assert code != 0 and "Illegal data address" in text
    assert read(run, COILS, 24, 5) == list(ENABLING)


def test_rc_outputs_are_discrete_inputs_and_the_same_in_input_registers(run: CellRun) -> None:
    """Outputs 64 ready; 66 drives on; bytes 8 and 9 are register 4, byte 8 its high one."""

    def ready() -> bool:
        write(run, COILS, 24, *ENABLING)
        return read(run, DISCRETES, 64, 1) == [1]

    assert within(5.0, ready)
    assert write(run, COILS, 24, *ENABLING)[0] == 0
    bits, (word,) = read(run, DISCRETES, 64, 16), read(run, INPUTS, 4, 1)
    assert bits[2] == 0, "drives are off"
    assert word == sum(bit << (n + 8 if n < 8 else n - 8) for n, bit in enumerate(bits))


def test_rc_outputs_are_not_for_writing(run: CellRun) -> None:
    """There is no function code for it: a coil and a holding register of that number are RC inputs."""
    before = read(run, DISCRETES, 64, 8)
    assert write(run, COILS, 64, 1)[0] != 0
    assert read(run, DISCRETES, 64, 8) == before


def test_the_first_command_block_is_adopted_and_the_next_toggle_is_obeyed(run: CellRun) -> None:
    """FC 16 of the whole block; word 0: toggle and code, status word 0: acknowledged toggle and state, word 1: reason, word 8: owner."""
    toggle = 0x8000

    def give(code: int) -> tuple[int, int]:
        write(run, COILS, 24, *ENABLING)
        assert write(run, HOLDINGS, BLOCK, toggle | code, 0, 10_000, 10_000, *[0] * 24)[0] == 0
        state, reason = read(run, INPUTS, BLOCK, 2)
        return state, reason

    assert give(REQUEST) == (0x8000, RESYNCHRONISED)
    assert read(run, INPUTS, BLOCK + 8, 1) == [0], "nobody has control: adopted is not obeyed"
    for _ in range(10):  # a command source silent for max_silence_ms (500) is resynchronised once more
        toggle ^= 0x8000
        state, reason = give(REQUEST)
        if reason != RESYNCHRONISED:
            break
    assert (state, reason) == (toggle | DONE, 0)
    assert read(run, INPUTS, BLOCK + 8, 1) == [SOURCE_OF_PLC2]
    assert read(run, HOLDINGS, BLOCK, 2) == [toggle | REQUEST, 0], "what was written stands"
