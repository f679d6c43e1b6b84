"""Which CAN port a URL names."""

from drivers.ports.base import CanPort, PortError
from drivers.ports.can.adapter_url import EXAMPLES, is_adapter


def open_can(url: str) -> CanPort:
    """`broker:NAME` (the local bus), `socketcan:IFACE` (the kernel's), or an adapter of python-can (never in the cycle: opening one
    blocks, see AX-435); PortError when it cannot be opened.

    A pair in memory, for tests, is `drivers.ports.can.memory.memory_pair()`.
    """
    scheme, colon, name = url.partition(":")
    if colon and name and scheme == "broker":
        from drivers.ports.can.broker import BrokerPort

        return BrokerPort(name)
    if colon and name and scheme == "socketcan":
        from drivers.ports.can.socketcan import SocketCanPort

        return SocketCanPort(name)
    if is_adapter(url):
        from drivers.ports.can.adapter import AdapterPort

        return AdapterPort(url)
    raise PortError(f"{url!r}: a CAN port is socketcan:INTERFACE, broker:NAME or an adapter of python-can, e.g. socketcan:can0, {EXAMPLES}")
