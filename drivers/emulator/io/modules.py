"""Emulated digital I/O modules of a CAN bus: they answer each SYNC with all input blocks; a coupled control answers our outputs.

Without wiring of their own the inputs follow the outputs of the same number (block 1 of the inputs block 1 of the outputs, and so
on): so a cell under trial shows activity.  Identifiers: rho 3 Releases part 5, 6.11-6.12 (L7433, L7449); 471..480 as input: part 8, 11.1.
"""

from collections.abc import Mapping, Sequence

from protocols.base.machine import Frame
from protocols.servodyn.plan import SYNC_ID

COUPLING = range(471, 481)


class IoModules:
    """`receive` frames of the control; returns the frames of the modules."""

    def __init__(self, inputs: Mapping[int, int], outputs: Sequence[int]) -> None:
        """`inputs`: identifier -> bytes; `outputs`: identifiers the control sends, both in the order of P31 and P32."""
        self._bytes = {identifier: bytes(length) for identifier, length in inputs.items()}
        self._outputs = tuple(outputs)
        self._wired = dict(zip(outputs, inputs, strict=False))
        self._coupled = [identifier for identifier in inputs if identifier in COUPLING]

    def receive(self, frames: Sequence[Frame]) -> list[Frame]:
        """Frames of one burst."""
        answers: list[Frame] = []
        for frame in frames:
            if frame.identifier == SYNC_ID:
                answers += [Frame(identifier, data) for identifier, data in self._bytes.items() if identifier not in self._coupled]
            elif frame.identifier in self._outputs:
                self._take(frame)
                if frame.identifier == self._outputs[-1]:  # the burst is over: the coupled control's own cycle comes now
                    answers += [Frame(identifier, self._bytes[identifier]) for identifier in self._coupled]
        return answers

    def _take(self, frame: Frame) -> None:
        wired = self._wired.get(frame.identifier)
        if wired is not None:
            length = len(self._bytes[wired])
            self._bytes[wired] = frame.data[:length].ljust(length, b"\0")
