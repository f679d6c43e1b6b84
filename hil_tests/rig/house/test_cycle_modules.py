"""The cycle process loads little: what is not there can neither be slow nor start a thread."""

import importlib.util
import subprocess
import sys

import pytest

CYCLE = "gateway.cycle.loop"
NEVER = ("pinocchio", "pin", "pymodbus", "asyncio", "rich", "can", "canopen", "cantools", "pydantic", "gateway.web", "hil_tests")


def modules_of(module: str) -> set[str]:
    """Names of everything loaded when a fresh process imports `module`."""
    script = f"import sys, {module}; print(*sys.modules)"
    return set(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split())


@pytest.mark.skipif(importlib.util.find_spec(CYCLE) is None, reason="the cycle process is not written yet")
def test_the_cycle_process_loads_none_of_the_big_ones() -> None:
    loaded = modules_of(CYCLE)
    assert [name for name in NEVER if name in loaded] == []


def test_the_services_load_neither_core_nor_numbers_they_do_not_need() -> None:
    """They must be back within 3 s of their death, also on a machine eight times slower."""
    loaded = modules_of("gateway.services.loop")
    assert [
        name
        for name in ("numpy", "pinocchio", "pymodbus", "gateway.pure.cycle.core", "motion.execution.stepper", "motion.execution.follower")
        if name in loaded
    ] == []


def test_the_list_of_loaded_modules_would_show_one_of_them() -> None:
    assert "asyncio" in modules_of("asyncio")
