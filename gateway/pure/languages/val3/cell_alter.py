"""alter of an application in a cell: its correction goes to the cycle in each turn, its mode comes back from there (AX-1062).  Pure."""

import math
import struct
from dataclasses import dataclass

from gateway.pure.cycle.correction_inputs import end_bit
from gateway.pure.image.records.correction import ProgramCorrection, pack_correction
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import Ns
from motion.program.blocks import Alteration, Until
from motion.program.blocks import Frame as BlockFrame
from motion.program.blocks import Tool as BlockTool
from motion.sync.alter import DONE, IGNORED, IN_ERROR, NO_OPTION, WAITS, Mode
from motion.val3.mdesc import Mdesc
from motion.val3.trsf import Trsf

_STATUS = struct.Struct(">bBh")  # answer, mode, alterStopTime in ms, as the cycle publishes them
MODES = tuple(Mode)
NOTHING = Trsf(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class AlterPlace:
    """[alter] with source = "application": RC input byte of the correction, RC output byte of the answer."""

    byte: int
    status: int


@dataclass(eq=False, slots=True)
class CellAlter:
    """part: of alterBegin, until its path is over; place None: the option is not there."""

    port: Port
    place: AlterPlace | None = None
    part: Alteration | None = None
    ended: bool = False  # alterEnd
    locked: bool = False  # an error, until resetMotion
    on_path: bool = False  # the path of the part has been handed on
    used: bool = False  # the path is over after its alterEnd, and no standard move followed it
    _next: Alteration | None = None  # alterBegin of the path to come
    _asked: bool = False  # alterBegin has answered 0, and no later one 1
    _value: Trsf = NOTHING
    _count: int = 0
    _sent: bool = False

    @property
    def _status(self) -> tuple[Mode, float]:
        """Mode of the cycle; alterStopTime in s."""
        assert self.place is not None
        outputs = self.port.view.channels.outputs
        _, mode, left = _STATUS.unpack_from(outputs, self.place.status)
        return MODES[mode] if mode < len(MODES) else Mode.OFF, -1.0 if left < 0 else left / 1e3

    # ---- instructions
    def begin(self, reference: BlockFrame | BlockTool, mdesc: Mdesc, unit_m: float, *, apart: bool = False) -> int:
        """alterBegin: 0 waits for its path, 1 once when called again on it, then -1; -2, -3; RuntimeFault 100..106.

        apart: a standard move is queued after the current path: after alterEnd the order is for the next one (L6294).
        """
        mdesc.check()
        if self.place is None:
            return NO_OPTION
        if self.locked:
            return IN_ERROR
        if (answer := self._again()) is not None:
            return answer
        coming = self.on_path and self.ended and apart and self._next is None
        if self.used or ((self.part is not None or self.on_path) and not coming):
            return IGNORED
        self._count += 1
        part = Alteration(
            reference, mdesc.vel / 100.0, mdesc.tvel * unit_m, math.radians(mdesc.rvel), mdesc.accel / 100.0, mdesc.decel / 100.0,
            Until(end_bit(self.place.byte), True), self._count,
        )  # fmt: skip
        if coming:
            self._next = part
        else:
            self._begun(part)
        self._asked = True
        return WAITS

    def _again(self) -> int | None:
        """Answer to a program that repeats an alterBegin until its path begins; None: nothing was asked."""
        if not self._asked or self._next is not None:
            return WAITS if self._asked else None
        if self.part is None or self.ended:
            self._asked = False
            return None
        mode, _ = self._status
        if not self.on_path or mode not in (Mode.ACTIVE, Mode.ERROR):
            return WAITS
        self._asked = False
        return DONE if mode is Mode.ACTIVE else IN_ERROR

    def _begun(self, part: Alteration | None) -> None:
        self.part, self.on_path, self.ended, self._value = part, False, False, NOTHING

    def alter(self, change: Trsf) -> int:
        """In force in the next cycle: 1, 0, -1, -2, -3."""
        if self.place is None:
            return NO_OPTION
        mode, left = self._status
        if self.locked or (mode is Mode.ERROR and self.part is not None):
            return IN_ERROR
        if self.part is None or self.ended or mode is not Mode.ACTIVE:
            return IGNORED
        if left == 0.0:
            return WAITS
        self._value = change
        return DONE if all(map(math.isfinite, change)) else IN_ERROR

    def end(self) -> int:
        """alterEnd: the present alteration stays for the rest of the path."""
        if self.locked:
            return IN_ERROR
        if self._next is not None:
            self._next = None
            return DONE
        if self.part is None or self.ended:
            return IGNORED
        if self.on_path:
            self.ended = True
        else:
            self.part = None
        return DONE

    def stop_time(self) -> float:
        """Negative: no stop is pending; 0: locked, or the mode is off."""
        if self.place is None or self.part is None or self.ended:
            return 0.0
        mode, left = self._status
        return left if mode is Mode.ACTIVE else 0.0

    # ---- the path
    def over(self, *, failed: bool, apart: bool = True) -> None:
        """End the altered path; orders for the next one wait for it; failed: no alteration until resetMotion.

        apart: a standard move is queued after it.
        """
        self.used = not apart and not failed
        self.locked = failed
        coming, self._next = None if failed else self._next, None
        self._begun(coming)

    def dropped(self) -> None:
        """resetMotion: nothing waits any more."""
        self._next = None
        self.over(failed=False)

    def correct(self, now: Ns) -> None:
        """At the end of a turn: what the cycle adds from now on."""
        if self.part is None and not self._sent:
            return
        self._sent = self.part is not None
        stamp = now if self.part is not None else 0
        self.port.correct(pack_correction(ProgramCorrection(stamp, tuple(self._value), self.ended)))
