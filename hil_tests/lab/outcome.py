"""What a call gave, or what it raised as a text: a test compares either, and a broken function shows as a difference."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def outcome(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | str:
    """The result, or repr of the exception."""
    try:
        return function(*args, **kwargs)
    except Exception as error:
        return repr(error)
