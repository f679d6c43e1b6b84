"""Any CAN adapter python-can knows, by one URL INTERFACE:CHANNEL, e.g. socketcan:can0, pcan:PCAN_USBBUS1, slcan:COM4."""

import contextlib
from collections.abc import Iterator

import can

from drivers.ports.base import PortError
from drivers.ports.can.adapter_url import adapter_of

FORM = "INTERFACE:CHANNEL, e.g. socketcan:can0, pcan:PCAN_USBBUS1, slcan:/dev/ttyACM0@500000, kvaser:0, broker:NAME"


class NoBus(OSError):
    """The adapter cannot be opened; the message names it and the remedy."""


@contextlib.contextmanager
def open_bus(url: str, bitrate: int, *, own: bool = False, fd: bool = False) -> Iterator[can.BusABC]:
    """bitrate: bit/s, for adapters that set it; `own`: receive own frames; `fd`: the kernel's frames of CAN FD as well (other adapters
    have options of their own for it).  Raises NoBus."""
    try:
        adapter = adapter_of(url)
    except PortError as error:
        raise NoBus(f"{url!r}: a bus is {FORM}") from error
    interface = adapter.interface
    options: dict[str, object] = {"receive_own_messages": True} if own else {}
    if interface not in ("socketcan", "broker", "virtual", "udp_multicast"):
        options["bitrate"] = adapter.bitrate or bitrate
    if fd and interface == "socketcan":
        options["fd"] = True
    options |= adapter.options
    try:
        bus = can.Bus(interface=interface, channel=adapter.channel, **options)  # type: ignore[arg-type]  # each adapter has its own options
    except (can.CanError, OSError, ImportError, ValueError, TypeError) as error:
        raise NoBus(f"{url}: {_advice(interface, error).removeprefix(f'{url}: ')}") from error
    try:
        yield bus
    finally:
        bus.shutdown()


def _advice(interface: str, error: Exception) -> str:
    text = str(error) or type(error).__name__
    if "Address family not supported" in text:
        return "this kernel has no CAN (modules can, can-raw); the local bus is broker:NAME, the guest of docs/guest.md has vcan0"
    if "Unknown interface" in text or "interface type" in text:
        return f"python-can knows no interface {interface!r}; {FORM}"
    return text
