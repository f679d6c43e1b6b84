"""A bus of the rho 3 as the cycle sees it: drives, digital I/O blocks and the parameter download in one language (AX-270).

Wraps the family of the drives, or is alone on a bus with I/O only.  Outputs are sent after the set values, then at most one parameter
request; received frames are passed to their owner.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from drivers.drives.family import BusFamily, Heard, SetRecord
from drivers.drives.servodyn_download import Download, DownloadState
from gateway.pure.controllers.rho3.can.blocks import IoBus
from gateway.pure.controllers.rho3.can.ledger import Ledger
from gateway.pure.controllers.rho3.can.messages import IoError
from gateway.pure.image.records.cell import InputImage, Quality
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns
from protocols.servodyn.codec import SYNC, SetValue
from protocols.servodyn.parameters import SLOT_OF_ANSWER, Answer, decode_answer, encode_request


@dataclass(frozen=True, slots=True)
class Parameters:
    """A download to one module, and the axis' index in the cell."""

    index: int
    run: Download


class RhoFamily:
    """A BusFamily.  `exchange` once per cycle, before the burst: what the last SYNC asked for has come by then."""

    def __init__(
        self, io: IoBus | None, drives: BusFamily | None = None, downloads: Mapping[int, Parameters] | None = None, number: int = 1
    ) -> None:
        """`downloads`: module on this bus -> its parameters; until they are through, the drive is not asked to come on.  `number`: of
        the bus, for messages."""
        self.ledger = Ledger()  # shared with the other buses of the cycle
        self._number = number
        self.io, self.drives = io, drives
        self.aside: list[Frame] = [] if drives is None else drives.aside
        self._downloads = dict(downloads or {})
        self._reported: set[int] = set()
        self._answer: Answer | None = None
        self._mine = frozenset(block.identifier for block in (*io.settings.inputs, *io.settings.outputs)) if io else frozenset[int]()
        self._outputs = bytearray(128)
        self._made: list[Frame] = []  # the burst that waits for its grid instant; its output blocks are filled at the last moment
        self._outputs_at = slice(0, 0)
        self._errors: list[IoError] = []
        self._now: Ns = 0
        self._met = False

    @property
    def expected(self) -> int:
        """Modules of inputs are not waited for: they are judged by cycles."""
        return self.drives.expected if self.drives else 0

    @property
    def awaited(self) -> bool:
        """A module that answered so far has not answered the last SYNC yet."""
        return self.io is not None and self.io.awaited

    @property
    def unconfigured(self) -> int:
        """Boosters and modules need no start-up."""
        return 0

    def burst(self, values: Sequence[SetRecord]) -> list[Frame]:
        """Set values and SYNC of the drives (a coupling bus has none), output blocks, one parameter request."""
        alone = [] if self.io is not None and self.io.coupled else [SYNC]
        frames = alone if self.drives is None else self.drives.burst(self._held(values))
        outputs = self.io.frames(self._outputs) if self.io else []
        self._made, self._outputs_at = [*frames, *outputs, *self._request()], slice(len(frames), len(frames) + len(outputs))
        return self._made

    def hear(self, frame: Frame) -> Heard | None:
        """Raises DecodeError for a frame this bus does not have."""
        if self.io is not None and frame.identifier in self._mine:
            self._errors += self.io.receive(frame, self._now)
            return None
        if frame.identifier in SLOT_OF_ANSWER and self._downloads:
            slot, answer = decode_answer(frame)
            if slot == next(iter(self._downloads)):
                self._answer = answer
            return None
        if self.drives is None:
            raise DecodeError(f"identifier {frame.identifier} is on no list of this bus")
        return self.drives.hear(frame)

    def exchange(self, image: InputImage, inputs: bytearray, now: Ns, *, up: bool) -> list[str]:
        """PIC outputs from `image` (invalid bytes are 0), PIC inputs into `inputs`; what a person should read.

        `up`: the bus is there.
        """
        io, self._now = self.io, now
        self._met = self._met or up
        if io is None or not self._met:
            return []  # a bus that was never there has no modules to supervise
        for block in io.settings.outputs:
            for byte in block.span:
                self._outputs[byte] = image.values[byte] if image.quality[byte] != Quality.BAD else 0
        fresh = io.frames(self._outputs)
        self._made[self._outputs_at] = fresh
        self._outputs_at = slice(self._outputs_at.start, self._outputs_at.start + len(fresh))
        found = [*self._errors, *io.cycle(now), *io.sent(len(io.settings.outputs) if up else 0)]
        self._errors = []
        if found:
            self.ledger.note(found)
        for block in io.settings.inputs:
            inputs[block.start : block.span.stop] = io.image[block.start : block.span.stop]
        return [str(error) for error in found]

    def take_news(self) -> list[str]:
        """Downloads that ended since the last call, in words."""
        ended = [(slot, each.run) for slot, each in self._downloads.items() if each.run.state is not DownloadState.RUNNING]
        for slot, run in ended:
            del self._downloads[slot]
            if run.error is not None:
                self.ledger.refused(self._number, slot, run.error)
        return [_words(slot, run) for slot, run in ended]

    def release(self, node: int, mode: int) -> None:
        if self.drives is not None:
            self.drives.release(node, mode)

    def hold(self, node: int) -> None:
        if self.drives is not None:
            self.drives.hold(node)

    def began(self, now: Ns) -> None:
        self._now = now
        if self.drives is not None:
            self.drives.began(now)

    def _held(self, values: Sequence[SetRecord]) -> Sequence[SetRecord]:
        """Delay drive-on until the parameters are sent: a drive accepts them only without power (AX-266)."""
        waiting = {each.index for each in self._downloads.values()}
        if not waiting:
            return values
        return [
            value._replace(drive_on=False, enable=False, brake_open=False) if n in waiting and isinstance(value, SetValue) else value
            for n, value in enumerate(values)
        ]

    def _request(self) -> list[Frame]:
        """The first drive whose download is not over; the others wait their turn."""
        for slot, each in self._downloads.items():
            answer, self._answer = self._answer, None
            request = each.run.step(answer)
            return [] if request is None else [encode_request(slot, request)]
        return []


def _words(slot: int, run: Download) -> str:
    if run.error is None:
        return f"module {slot}: {len(run.taken)} parameters taken"
    number = f"{run.error.number} " if run.error.number else ""
    return f"module {slot}: parameters not taken: {number}{run.error.english}"
