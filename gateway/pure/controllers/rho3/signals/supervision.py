"""A PLC that does not answer, and a PIC whose timer fails.  Source: rho3 3.3 (L11717-11732), 0.1 (L707), AX-506, AX-507."""

import re
from collections.abc import Callable

from gateway.pure.controllers.pic_image import PicImage
from protocols.base.machine import Ns, ms

START_UP_GRACE = ms(80_000)  # since TO07J


def has_grace(version: str, remote: bool) -> bool:
    """Whether this software waits at start-up: TO07J and later, never where the control is remote (AX-506).  ValueError: no version."""
    found = re.fullmatch(r"TO(\d\d)([A-Z])", version)
    if found is None:
        raise ValueError(f"{version!r}: a software version such as TO07J expected")
    return (int(found[1]), found[2]) >= (7, "J") and not remote


class PlcWatch:
    """Silence of the PLC: at start-up 80 s more are allowed, after the first transmission the normal time-out counts."""

    def __init__(self, timeout: Ns, now: Ns, grace: bool = True) -> None:
        """`now`: start-up of the control; `grace`: see has_grace."""
        self._timeout = timeout
        self._due = now + timeout + (START_UP_GRACE if grace else 0)
        self.silent = False

    def heard(self, now: Ns) -> None:
        """The PLC has transmitted."""
        self._due, self.silent = now + self._timeout, False

    def wake(self, now: Ns) -> bool:
        """True once, when the PLC has been silent too long."""
        if self.silent or now < self._due:
            return False
        self.silent = True
        return True

    def deadline(self) -> Ns | None:
        """When to call wake; None after the time-out."""
        return None if self.silent else self._due


class PicGuard:
    """Runs the PIC's program; a timer error stops it for good: READY opens, all RC inputs and outputs stay 0 until a restart."""

    def __init__(self, longest: Ns, settles: int = 0) -> None:
        """`longest`: time between two runs beyond which the timer counts as failed; `settles`: runs after start-up that may be late."""
        self._longest, self._settles = longest, settles
        self._last: Ns | None = None
        self.stopped = False

    @property
    def ready(self) -> bool:
        """The READY contact is closed."""
        return not self.stopped

    def timer_error(self, image: PicImage) -> None:
        """The timer has failed."""
        self.stopped = True
        image.clear()

    def run(self, image: PicImage, now: Ns, program: Callable[[PicImage], None]) -> None:
        """One cycle of the PIC, or none where it is stopped."""
        late = self._last is not None and now - self._last > self._longest and not self._settles
        self._last, self._settles = now, max(0, self._settles - 1)
        if self.stopped or late:
            self.timer_error(image)
            return
        program(image)
