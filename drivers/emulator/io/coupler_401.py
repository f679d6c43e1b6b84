"""CiA 401 couplers, emulated: digital inputs 6000h, digital outputs 6200h with error mode and error value, on a bus with drives.

Source: CiA 401 (6000h, 6005h, 6200h, 6206h, 6207h); communication: CiA 301.  Without wiring of their own the inputs follow the outputs of
the same number, as the digital I/O modules do, so that a cell under trial shows activity; `wire` sets an input to a level of its own.
"""

from collections.abc import Mapping, Sequence

from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.canopen.objects import Objects
from protocols.base.machine import Frame, FrameFault, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.nmt import State

INPUTS, OUTPUTS, ERROR_MODE, ERROR_VALUE, INTERRUPTS = 0x6000, 0x6200, 0x6206, 0x6207, 0x6005
OCTETS = 4
BOOT_NS: Ns = 50_000_000
FAR: Ns = 1 << 62


class Terminals:
    """The device: terminals, and the state of its outputs without a master."""

    def __init__(self, objects: Objects, node: CanopenNode) -> None:
        self._objects, self._node = objects, node
        self._wired: dict[int, bool] = {}
        self._reported = bytes(OCTETS)
        self._state = State.INITIALISING

    @property
    def outputs(self) -> bytes:
        """Levels of the terminals."""
        return bytes(self._objects.whole((OUTPUTS, sub)) for sub in range(1, OCTETS + 1))

    def wire(self, channel: int, level: bool | None) -> None:
        """Input from outside; None: it follows the output of its number again."""
        if level is None:
            self._wired.pop(channel, None)
        else:
            self._wired[channel] = level
        self._read()

    def _read(self) -> None:
        octets = bytearray(self.outputs)
        for channel, level in self._wired.items():
            octets[channel // 8] = octets[channel // 8] & ~(1 << channel % 8) | level << channel % 8
        for sub, octet in enumerate(octets, 1):
            self._objects.values[INPUTS, sub] = octet

    def fall(self) -> None:
        """Outputs in error mode change to their error values; the others stay."""
        for sub in range(1, OCTETS + 1):
            mask, value = self._objects.whole((ERROR_MODE, sub)), self._objects.whole((ERROR_VALUE, sub))
            self._objects.values[OUTPUTS, sub] = self._objects.whole((OUTPUTS, sub)) & ~mask | value & mask
        self._read()

    # -- Application ----------------------------------------------------------------------------
    def advance(self, now: Ns) -> None:
        """Leaving operational in any way means losing the master of the outputs."""
        if self._state is State.OPERATIONAL and self._node.state is not State.OPERATIONAL:
            self.fall()
        self._state = self._node.state
        self._read()

    def sample(self, now: Ns) -> None:
        self._read()

    def activate(self, now: Ns) -> None:
        self._read()

    def connection_lost(self, now: Ns) -> None:
        self.fall()

    def reset(self, now: Ns) -> None:
        for sub in range(1, OCTETS + 1):
            self._objects.values[OUTPUTS, sub] = 0
        self._read()

    def changed(self) -> bool:
        self._read()
        now = bytes(self._objects.whole((INPUTS, sub)) for sub in range(1, OCTETS + 1))
        before, self._reported = self._reported, now
        return now != before and bool(self._objects.whole((INTERRUPTS, 0)))


class Couplers:
    """All couplers of one bus; `receive`, `wake`, `deadline`, `take_output` as the FrameMachines have them, in bus time."""

    grace_ns: Ns = 2_000_000

    def __init__(self, dictionaries: Mapping[int, ObjectDictionary]) -> None:
        self.nodes: dict[int, CanopenNode] = {}
        self.terminals: dict[int, Terminals] = {}
        for number, dictionary in dictionaries.items():
            self.nodes[number] = CanopenNode(dictionary, number, _Maker(self.terminals, number))
            self.nodes[number].boot_ns = BOOT_NS
        self._begun = False
        self._output: list[Frame] = []

    def receive(self, frames: Sequence[Frame], now: Ns) -> None:
        """Frames of the bus; those for others have no effect here."""
        for frame in frames:
            stamp = frame.stamp_ns or now
            self.wake(stamp)
            for number, node in self.nodes.items():
                handler = node.accepted.data.get(frame.identifier)
                if handler is None or node.silent:
                    continue
                handler(frame, stamp)
                self.terminals[number].advance(stamp)
                if frame.identifier == cobid.rpdo(1, number):
                    node.events(stamp)
                self._collect(node)

    def error_frame(self, kind: FrameFault, now: Ns) -> None:
        """The device does not depend on it."""

    def wake(self, now: Ns) -> None:
        """Handle what has expired by bus time `now`."""
        if not self._begun:
            self._begun = True
            for node in self.nodes.values():
                node.power_up(now)
                self._collect(node)
        for number, node in self.nodes.items():
            if node.soonest <= now:
                self.terminals[number].advance(now)
                node.expire(now)
                self.terminals[number].advance(now)
                self._collect(node)

    def deadline(self) -> Ns | None:
        soonest = min((node.soonest for node in self.nodes.values()), default=FAR)
        return None if soonest >= FAR else soonest

    def take_output(self) -> list[Frame]:
        output, self._output = self._output, []
        return output

    def wire(self, number: int, channel: int, level: bool | None, now: Ns) -> None:
        """A level at an input terminal; KeyError: no such coupler."""
        self.terminals[number].wire(channel, level)
        self.nodes[number].events(now)
        self._collect(self.nodes[number])

    def _collect(self, node: CanopenNode) -> None:
        if node.output:
            if not node.silent:
                self._output += node.output
            node.output = []
            node.emergencies.send = node.output.append
        node.plan(FAR)


class _Maker:
    """Makes the terminals of one node and keeps them where the test and the process find them."""

    def __init__(self, kept: dict[int, Terminals], number: int) -> None:
        self._kept, self._number = kept, number

    def __call__(self, objects: Objects, node: CanopenNode) -> Terminals:
        self._kept[self._number] = Terminals(objects, node)
        return self._kept[self._number]
