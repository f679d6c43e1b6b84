"""A test whose subject raises what nobody expected has been answered wrongly: that is the test's own no, not a crash."""

import functools
from collections.abc import Callable
from typing import ParamSpec

P = ParamSpec("P")


def answers(test: Callable[P, None]) -> Callable[P, None]:
    """Turns any exception that runs through the test into a failed assertion."""

    @functools.wraps(test)
    def judged(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            test(*args, **kwargs)
        except AssertionError:
            raise
        except Exception as failure:
            raise AssertionError(f"raised {failure!r}") from failure

    return judged
