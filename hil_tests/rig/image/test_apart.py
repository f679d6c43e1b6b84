"""Work in a copy of the process: its result, its words and its faults reach the caller, what it loaded does not (AX-1740)."""

import os
import subprocess
import sys

import pytest

from gateway.runtime.apart import apart


def test_a_cell_is_checked_without_its_checker_in_the_process() -> None:
    program = (
        "import sys\n"
        "from gateway.tools.cell_argument import load_apart\n"
        "cell = load_apart('demo')\n"
        "print(cell.cell.name, [name for name in sys.modules if name in ('pydantic', 'gateway.cell_file.load')])\n"
    )
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert told.stdout.endswith(" []\n"), told


def test_the_result_and_the_words_come_back(capfd: pytest.CaptureFixture[str]) -> None:
    print("before ", end="")

    def work() -> tuple[int, list[str]]:
        print("inside")
        return os.getpid(), ["a", "b"]

    pid, rest = apart(work)
    assert pid != os.getpid() and rest == ["a", "b"]
    assert capfd.readouterr().out == "before inside\n"


def test_a_fault_is_raised_in_the_caller() -> None:
    with pytest.raises(ZeroDivisionError):
        apart(lambda: 1 // 0)


def test_a_copy_that_is_killed_costs_only_its_time() -> None:
    caller = os.getpid()

    def work() -> int:
        if os.getpid() != caller:
            os.kill(os.getpid(), 9)
        return 7

    assert apart(work) == 7


def test_without_another_process_the_work_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    def none_left() -> int:
        raise BlockingIOError(11, "no process left")

    monkeypatch.setattr(os, "fork", none_left)
    assert apart(os.getpid) == os.getpid()


@pytest.mark.parametrize("closed", ["<&-", ">&-", "<&- >&-"])
def test_a_run_may_be_started_without_standard_streams(closed: str) -> None:
    command = ["sh", "-c", f'exec "$0" -m gateway run no-such-cell {closed}', sys.executable]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 2 and told.stderr.startswith("axisgate: no-such-cell: no such file"), told
