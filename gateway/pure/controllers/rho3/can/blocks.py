"""Digital I/O blocks of one CAN bus: PIC bytes out of frames and into frames, and who is supervised how.

Source: rho 3 Releases part 5, 6.11-6.14 (L7423-7527); coupling of controls: part 8, 11.1 (L10960-10998).  An input under one of
471..480 comes from another control: it is watched by time (300 ms), from the moment all controls have answered, at the latest 60 s
after the start; an input of a module is watched by P2 cycles from its second one on.  What the text leaves open: AX-262, AX-263.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.controllers.rho3.can.messages import IoError, Trouble
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.controllers.rho3.can.tables import OUTPUT_IDS, Side
from gateway.pure.image.fast_inputs import InputLevel
from protocols.base.machine import Frame, Ns, ms


@dataclass(frozen=True, slots=True)
class IoSettings:
    """One bus; raises nothing, `rules.judge` has seen it before."""

    bus: int  # 1 or 2, for the messages
    inputs: tuple[Block, ...] = ()
    outputs: tuple[Block, ...] = ()
    coupling_ns: Ns | None = ms(300)  # changed or removed by an option flag (L10989-10991); None: not supervised
    start_ns: Ns = ms(60_000)
    zero_on_loss: bool = True  # else a lost input keeps its last bytes
    give_up: bool = False  # as the manual: after a partner was silent at the start nothing is sent any more (L10993-10996)


@dataclass(slots=True)
class _Input:
    number: int
    block: Block
    coupled: bool
    came: int = 0  # frames in the running P2 cycle
    due: int = 1  # how many may come in it: a late one of the cycle before counts there already
    heard: bool = False  # ever
    last_ns: Ns = 0
    changed_ns: Ns = 0  # bus stamp of the first frame with these bytes
    error: Trouble | None = None


class IoBus:
    """Receive every frame of the bus, call `cycle` once at the end of a P2 cycle, send `frames` with the next burst."""

    def __init__(self, settings: IoSettings, now: Ns) -> None:
        """`now`: start of this control."""
        self.settings = settings
        self.aborted = False
        self.image = bytearray(128)  # PIC inputs as this bus knows them
        self._inputs = [_Input(n, block, block.identifier in OUTPUT_IDS) for n, block in enumerate(settings.inputs, 1)]
        self._by_id = {entry.block.identifier: entry for entry in self._inputs}
        self._outputs = {block.identifier: number for number, block in enumerate(settings.outputs, 1)}
        self._start = now
        self._supervised_from: Ns | None = None  # coupled inputs: all have answered, or the start-up time is over
        self._cycles = 0
        self._last: list[Frame] = []
        self._faulty: set[tuple[Trouble, int]] = set()  # of output blocks

    @property
    def coupled(self) -> bool:
        """Another control is on this bus: nothing else may be (L10966-10968), and it has no master."""
        return any(entry.coupled for entry in self._inputs)

    @property
    def errors(self) -> list[IoError]:
        """Present contents."""
        bus = self.settings.bus
        active = [IoError(entry.error, bus, entry.number) for entry in self._inputs if entry.error is not None]
        return active + [IoError(trouble, bus, number) for trouble, number in sorted(self._faulty, key=lambda pair: pair[1])]

    @property
    def awaited(self) -> bool:
        """A module that answered so far has not answered the last SYNC yet."""
        return self._cycles > 0 and any(
            not entry.coupled and not entry.came and entry.error is not Trouble.SILENT for entry in self._inputs
        )

    def untrusted(self) -> list[int]:
        """Bytes of inputs that are invalid now: never received, or in error."""
        return [byte for entry in self._inputs if entry.error is not None or not entry.heard for byte in entry.block.span]

    def input_at(self, byte: int, bit: int) -> InputLevel | None:
        """One PIC input of a block of this bus; None while it is invalid."""
        entry = next(entry for entry in self._inputs if byte in entry.block.span)
        return InputLevel(bool(self.image[byte] >> bit & 1), entry.changed_ns) if entry.heard and entry.error is None else None

    def receive(self, frame: Frame, now: Ns) -> list[IoError]:
        """Process one frame of the bus and return its errors; frames of others (drives, SYNC) are ignored."""
        entry = self._by_id.get(frame.identifier)
        if entry is None:
            return self._foreign(frame.identifier)
        entry.came += 1
        if len(frame.data) < entry.block.length or (entry.came > entry.due and not entry.coupled):
            return self._raise(entry, Trouble.INADMISSIBLE)
        place, data = slice(entry.block.start, entry.block.span.stop), frame.data[: entry.block.length]  # of a longer frame no more
        if self.image[place] != data or not entry.heard:
            self.image[place], entry.changed_ns = data, frame.stamp_ns
        entry.last_ns, entry.heard = now, True
        return self._clear(entry) if entry.error is Trouble.SILENT or entry.coupled else []

    def cycle(self, now: Ns) -> list[IoError]:
        """A P2 cycle is over: who was silent, who is well again."""
        self._cycles += 1
        self._judge_start(now)
        found: list[IoError] = []
        for entry in self._inputs:
            if entry.coupled:
                found += self._watch_time(entry, now)
            elif not entry.came and self._cycles > 1:
                found += self._raise(entry, Trouble.SILENT)
            elif entry.came == 1 and entry.error is Trouble.INADMISSIBLE:
                found += self._clear(entry)
            entry.due, entry.came = 1 if entry.came else 2, 0
        return found

    def frames(self, image: Sequence[int] | bytes) -> list[Frame]:
        """The output blocks out of the PIC outputs (128 bytes), in the order of P32."""
        if self.aborted and self.settings.give_up:
            return []
        self._last = [Frame(block.identifier, bytes(image[block.start : block.span.stop])) for block in self.settings.outputs]
        return list(self._last)

    def live(self, side: Side) -> list[tuple[int, bytes]]:
        """Identifier and bytes of every block as they are now: what PHG modes 7.14 (inputs) and 7.15 (outputs) show (L7459-7475)."""
        if side is Side.OUTPUT:
            return [(frame.identifier, frame.data) for frame in self._last]
        return [(entry.block.identifier, bytes(self.image[entry.block.start : entry.block.span.stop])) for entry in self._inputs]

    def sent(self, count: int) -> list[IoError]:
        """The interface took the first `count` of the frames; the others are write access refused (L7513-7518)."""
        found = []
        for number in self._outputs.values():
            entry = (Trouble.WRITE_DISABLED, number)
            if number > count and entry not in self._faulty:
                self._faulty.add(entry)
                found.append(IoError(entry[0], self.settings.bus, number))
            elif number <= count and entry in self._faulty:
                self._faulty.remove(entry)
                found.append(IoError(entry[0], self.settings.bus, number, active=False))
        return found

    def _judge_start(self, now: Ns) -> None:
        if self._supervised_from is not None:
            return
        coupled = [entry for entry in self._inputs if entry.coupled]
        if all(entry.heard for entry in coupled):
            self._supervised_from = now
        elif now - self._start >= self.settings.start_ns:
            self._supervised_from, self.aborted = now, True

    def _watch_time(self, entry: _Input, now: Ns) -> list[IoError]:
        limit = self.settings.coupling_ns
        if self._supervised_from is None:
            return []
        if not entry.heard:
            return self._raise(entry, Trouble.SILENT)  # the start-up time is over (also where the 300 ms are switched off)
        if limit is None or now - entry.last_ns < limit:
            return []
        return self._raise(entry, Trouble.SILENT)

    def _raise(self, entry: _Input, trouble: Trouble) -> list[IoError]:
        if entry.error is trouble:
            return []
        entry.error = trouble
        if trouble is Trouble.SILENT and self.settings.zero_on_loss:
            for byte in entry.block.span:
                self.image[byte] = 0
        return [IoError(trouble, self.settings.bus, entry.number)]

    def _clear(self, entry: _Input) -> list[IoError]:
        before, entry.error = entry.error, None
        return [] if before is None else [IoError(before, self.settings.bus, entry.number, active=False)]

    def _foreign(self, identifier: int) -> list[IoError]:
        """Our own output identifier from somebody else: two controls send the same one (L10998)."""
        number = self._outputs.get(identifier)
        if number is None or (Trouble.SAME_IDENTIFIER, number) in self._faulty:
            return []
        self._faulty.add((Trouble.SAME_IDENTIFIER, number))
        return [IoError(Trouble.SAME_IDENTIFIER, self.settings.bus, number)]
