"""dio and aio variables: what VAL 3 instructions do with them.  Source: val3 3.1 (=), 3.5 (L2290-2564)."""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.controllers.val3.io.system import IoSystem, Point, RunTime, RunTimeFault


class CompileFault(Exception):
    """The compiler refuses it."""


@dataclass(slots=True)
class Dio:
    """A digital variable; `link` names a system point, None: none yet."""

    link: str | None = None


@dataclass(slots=True)
class Aio:
    """An analog variable."""

    link: str | None = None


class Instructions:
    """The instructions, each under its name in the language."""

    def __init__(self, system: IoSystem) -> None:
        self._system = system

    def dio_link(self, variable: Dio, source: Dio) -> None:
        """dioLink: the variable receives the source's link, also none."""
        variable.link = source.link

    def aio_link(self, variable: Aio, source: Aio) -> None:
        """aioLink."""
        variable.link = source.link

    def value(self, variable: Dio) -> bool:
        """A dio read as a bool; RunTimeFault 123 unlinked."""
        return bool(self._system.raw(self._digital(variable.link, write=False)))

    def assign(self, variable: Dio, value: bool | Dio) -> bool:
        """dio = bool, which returns the bool; CompileFault for dio = dio, RunTimeFault 122 for an input."""
        if isinstance(value, Dio):
            raise CompileFault("dio = dio: write diOut = (diIn == true)")
        self._put(variable, value)
        return value

    def dio_get(self, variables: Sequence[Dio]) -> int:
        """dioGet: the array as a number, its first element lowest."""
        return sum(1 << at for at, variable in enumerate(variables) if self.value(variable))

    def dio_set(self, variables: Sequence[Dio], value: float) -> int:
        """dioSet: the integer part in binary to the outputs; returns what they can show of it."""
        points = [self._digital(variable.link, write=True) for variable in variables]  # all or nothing
        shown = int(value) & (1 << len(points)) - 1
        for at, point in enumerate(points):
            self._system.put(point, shown >> at & 1)
        return shown

    def aio_get(self, variable: Aio) -> float:
        """aioGet: the value in its unit; RunTimeFault 123 unlinked."""
        point = self._system.usable(variable.link)
        if not point.steps:
            raise RunTimeFault(RunTime.NO_LINK, point.path)
        return self._system.raw(point) / point.steps

    def aio_set(self, variable: Aio, value: float) -> float:
        """aioSet: return the value as the output accepts it, or the output's present value where it is out of range."""
        point = self._system.writable(variable.link)
        wanted = float(int(value)) if point.integer and point.low - 1 < value < point.high + 1 else value
        if not point.low <= wanted <= point.high:
            return self.aio_get(variable)
        self._system.put(point, round(wanted * point.steps))
        return wanted

    def io_status(self, variable: Dio | Aio) -> int:
        """ioStatus."""
        return int(self._system.status(variable.link))

    def io_description(self, variable: Dio | Aio) -> tuple[int, str, str]:
        """ioStatus with the configured description and physical path (L2427; "" where there is none)."""
        point = self._system.point(variable.link)
        return self.io_status(variable), point.description if point else "", point.path if point else ""

    def _put(self, variable: Dio, value: bool) -> None:
        self._system.put(self._digital(variable.link, write=True), int(value))

    def _digital(self, link: str | None, write: bool) -> Point:
        point = self._system.writable(link) if write else self._system.usable(link)
        if point.steps:
            raise RunTimeFault(RunTime.NO_LINK, point.path)
        return point
