"""Calls whose exceptions are failed assertions."""

from collections.abc import Callable
from typing import TypeVar

R = TypeVar("R")


def sound(call: Callable[[], R]) -> R:
    """What `call` returns."""
    try:
        return call()
    except AssertionError:
        raise
    except Exception as error:
        raise AssertionError(f"raised {error!r}") from error
