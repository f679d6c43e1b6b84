"""The PIC of the interpreter as the control has it: its outputs, flags, timers and counters (AX-981).  Pure."""

from collections.abc import Callable, Mapping

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.image.records.cell import get_bit, set_bit
from gateway.pure.image.records.interpreter import Fact
from protocols.base.machine import Ns

FIRST_WIRED, WIRED = 88, 8  # digital inputs I88.0 to I95.7 (L11190)
NAME = "rho3.pic.input"


class PicLink:
    """`orders` go to the interpreter; `take` is what writes its RC inputs: the command source `pic`."""

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
