"""Common base of all testers: notes of a case, times as intervals, judged and preparing steps."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from gateway.conformance.framework.power import Supply
from gateway.pure.conformance.interval import Measure, Place
from gateway.pure.conformance.verdict import Fail, Inconclusive, Uncertain
from protocols.base.machine import Ns, ms

TOLERANCE = ms(20)  # and one character time (serial-protocols 6)


@dataclass(frozen=True, slots=True)
class Seen:
    """One piece of a trace."""

    ns: Ns
    side: str  # "tester" or "device"
    data: bytes
    note: str = ""  # a damaged character, a closed connection: events without bytes
    identifier: int | None = None  # of a CAN frame

    def shown(self) -> str:
        """For the trace of a report."""
        if self.note:
            return f"[{self.note}]"
        return self.data.hex(" ").upper() if self.identifier is None else f"{self.identifier & 0x7FF:03X}#{self.data.hex().upper()}"


@dataclass(slots=True)
class Notes:
    """Observations of one case."""

    measures: list[Measure] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    trace: list[Seen] = field(default_factory=list)
    unasked: int = 0  # blocks or frames the device sent on its own


class Tester:
    """Common part of the testers of all suites."""

    clock = "monotonic clock of this host"

    def __init__(self) -> None:
        self.notes = Notes()
        self.supply: Supply | None = None  # of the device
        self.case = ""  # id of the running one
        self._preparing = 0

    def late(self) -> Ns:
        """By how much this host was held up since the case began."""
        return 0

    def standing(self) -> None:
        """Judged at the end of each case that did not end before: what holds in all of them."""

    def uncertainty(self) -> Ns:
        """Uncertainty of a measured time."""
        return self.late()

    def doubt(self, took: Ns) -> tuple[Ns, Ns]:
        """Uncertainty of a time that is over now, and the most that is left to its device where it would be FAIL."""
        return self.uncertainty(), self.uncertainty()

    @contextlib.contextmanager
    def given(self) -> Iterator[None]:
        """Preparing steps: a failure here is INCONC, another purpose judges it."""
        self._preparing += 1
        try:
            yield
        except Fail as failed:
            raise Inconclusive(f"preamble: {failed.reason}", failed.expected, failed.got) from failed
        finally:
            self._preparing -= 1

    @property
    def power(self) -> Supply:
        """Supply of a case that has `power` as its condition."""
        assert self.supply is not None, "the condition of the case"
        return self.supply

    def remark(self, text: str) -> None:
        self.notes.remarks.append(text)

    def timed(self, what: str, took: Ns, least: Ns | None, most: Ns | None) -> None:
        """Record a time; FAIL if its complete interval is outside the limits, repeated if it overlaps one."""
        took = max(took, 0)  # a port without a serial line answers before the counted time of the characters is over
        near, far = self.doubt(took)
        measure = Measure(what, took, least, most, near, self.clock)
        self.notes.measures.append(measure)
        shown = f"{took / 1e6:.1f} ms (uncertainty {measure.uncertainty / 1e6:.1f} ms)"
        if self._preparing or measure.place() is Place.INSIDE:
            return
        if measure.place() is Place.OUTSIDE and replace(measure, uncertainty=max(near, far)).place() is Place.OUTSIDE:
            raise Fail(f"{what}: {shown}, limits: {measure.limits()}", measure.limits(), shown)
        raise Uncertain(f"{what}: {shown} overlaps its limits: {measure.limits()}", measure.limits(), shown)


def hexed(data: bytes, most: int = 48) -> str:
    """Bytes for a reader; long ones are cut."""
    return data[:most].hex(" ").upper() + (f" .. ({len(data)} bytes)" if len(data) > most else "") if data else "nothing"
