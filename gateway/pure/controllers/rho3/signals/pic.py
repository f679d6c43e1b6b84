"""The PIC of the interpreter as the control has it: its outputs, flags, timers and counters (AX-981).  Pure."""

from collections.abc import Callable, Collection, Mapping

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.image.records.cell import get_bit, set_bit
from gateway.pure.image.records.interpreter import Fact
from protocols.base.machine import Ns

FIRST_WIRED, WIRED = 88, 8  # digital inputs I88.0 to I95.7 (L11190)
NAME = "rho3.pic.input"
OFF_NS = 500_000_000  # drives without their enabling inputs are off by then


class PicLink:
    """`orders` go to the interpreter; `take` writes its RC inputs: the command source `pic`."""

    def __init__(self, image: PicImage, timers: TimersAndCounters) -> None:
        self._image, self._timers = image, timers
        self.orders: list[dict[str, Fact]] = []
        self.take: Callable[[bytes, Ns], None] | None = None
        self.gone: Callable[[], None] | None = None  # the one that scanned is not there any more
        self.stopped = False  # its program did not end
        self._noted = False
        self.wired = bytearray(WIRED)

    def welcome(self) -> None:
        """An interpreter has begun: flags and counters as they are kept here."""
        self.stopped = self._noted = False
        if self.gone is not None:
            self.gone()
        counters = ",".join(str(each) for each in self._timers.counters)
        self.orders.append({"do": "pic", "flags": bytes(self._image.flags).hex(), "counters": counters})

    def hear(self, said: Mapping[str, Fact], now: Ns) -> None:
        """After a scan."""
        self._image.flags[:] = bytes.fromhex(str(said["flags"]))
        self._timers.counters[:] = _numbers(said["counters"])
        self._timers.left[:] = [1_000_000 * each for each in _numbers(said["left"])]
        if self.take is not None:
            self.take(bytes.fromhex(str(said["outputs"])), now)

    def write_flags(self, first: int, data: bytes) -> None:
        """Others have written flags."""
        self.orders.append({"do": "pic-flags", "first": first, "data": data.hex()})

    def fails(self) -> bool:
        """True once where its program did not end."""
        first, self._noted = not self._noted, True
        return first

    def overlay(self) -> None:
        """Its digital inputs into the image."""
        self._image.outputs[FIRST_WIRED : FIRST_WIRED + WIRED] = self.wired

    def names(self) -> list[str]:
        """Its digital inputs, to be wired."""
        return [f"{NAME}.{FIRST_WIRED + byte}.{bit}" for byte in range(WIRED) for bit in range(8)]

    def value(self, name: str) -> float:
        """One of them."""
        return float(get_bit(self.wired, _bit(name)))

    def wire(self, name: str, value: bool) -> None:
        """One of them becomes `value`."""
        set_bit(self.wired, _bit(name), value)


def _bit(name: str) -> int:
    byte, bit = name.removeprefix(f"{NAME}.").split(".")
    return 8 * (int(byte) - FIRST_WIRED) + int(bit)


def _numbers(text: Fact) -> list[int]:
    return [int(each) for each in str(text).split(",")]


class FreshEdges:
    """Edges of a PIC that comes back: its bytes stay 0 until the drives are off, and edge-triggered bits must fall first (AX-981)."""

    def __init__(self, edges: Collection[int]) -> None:
        """edges: RC inputs."""
        self._edges = tuple(edges)
        self._held: set[int] = set()  # have not fallen yet
        self._scanned = self._lost = False
        self._until: Ns | None = None

    def lost(self) -> None:
        """The one that scanned is gone; before the first scan there was none."""
        self._lost, self._until = self._scanned, None

    def passed(self, outputs: bytes, now: Ns) -> bytes | None:
        """O0 to O127 as they act; None: not yet."""
        self._scanned = True
        if self._lost:
            self._until = now + OFF_NS if self._until is None else self._until
            if now < self._until:
                return None
            self._lost, self._held = False, set(self._edges)
        self._held = {bit for bit in self._held if outputs[bit >> 3] >> (bit & 7) & 1}
        acting = bytearray(outputs)
        for bit in self._held:
            acting[bit >> 3] &= ~(1 << (bit & 7))
        return bytes(acting)
