"""Inside `with asserted():` an exception nobody expected is a failed assertion: what is tested did not do what it should."""

import contextlib
from collections.abc import Iterator


@contextlib.contextmanager
def asserted() -> Iterator[None]:
    """Assertions pass through, every other exception becomes one."""
    try:
        yield
    except AssertionError:
        raise
    except Exception as error:
        raise AssertionError(f"{type(error).__name__}: {error}") from error
