"""A test whose subject raises what nobody expected has been answered wrongly: that is the test's own no, not a crash."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def answers(test: Callable[P, R]) -> Callable[P, R]:
    """Turns any exception that runs through the test, or the fixture that drives what it judges, into a failed assertion."""

    @functools.wraps(test)
    def judged(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return test(*args, **kwargs)
        except AssertionError:
            raise
        except Exception as failure:
            raise AssertionError(f"raised {failure!r}") from failure

    return judged
