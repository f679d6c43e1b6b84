"""What `axisgate check` loads: for a cell whose checks plan nothing neither the trajectory library nor numpy nor a language."""

import json
import subprocess
import sys

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import names_in

CONTROLS = "gateway.assembly.controllers"  # of all kinds: a third of a check's time
HEAVY = ("ruckig", "numpy", "pinocchio", "can", "canopen", "pymodbus", "asyncio", "gateway.pure.languages.baps2.library")
CHECK = (
    "import json, sys; from gateway.commands.check import main; code = main([sys.argv[1]]); "
    "print(json.dumps([code, [name for name in sys.argv[2:] if name in sys.modules]]))"
)


def checked(cell: str) -> object:
    """Exit code of a fresh interpreter's check, and which heavy modules it has."""
    return loaded(cell, *HEAVY)


def loaded(cell: str, *modules: str) -> object:
    done = subprocess.run([sys.executable, "-c", CHECK, cell, *modules], capture_output=True, text=True, timeout=60, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def has_programs(name: str) -> bool:
    """Motion programs, or programs of the old controller: in its memory (AX-860), on its disk (AX-930)."""
    cell = load_cell(name)
    return bool(cell.program) or cell.val3 is not None or (cell.controller is not None and bool(cell.controller.memory))


@pytest.mark.parametrize("name", [name for name in names_in("cells") if not has_programs(name)])
def test_a_cell_without_programs_is_checked_without_planning(name: str) -> None:
    assert checked(name) == [0, []]


def test_a_cell_without_a_controller_is_checked_without_one() -> None:
    assert loaded("demo", CONTROLS) == [0, []]
    assert loaded("rho3-coupled", CONTROLS) == [0, [CONTROLS]]


def test_motion_programs_bring_what_their_dry_run_needs() -> None:
    assert checked("portal") == [0, ["ruckig", "numpy"]]
    assert checked("palletiser") == [0, ["numpy", "gateway.pure.languages.baps2.library"]], (
        "the kinematics of the robot that BAPS2 programs move"
    )
