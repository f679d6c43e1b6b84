"""Which CAN port a URL names."""

from drivers.ports.base import CanPort, PortError


def open_can(url: str) -> CanPort:
    """`broker:NAME` (the local bus) or `socketcan:IFACE` (the kernel's); PortError when it cannot be opened.

    A pair in memory, for tests, is `drivers.ports.canmemory.memory_pair()`.
    """
    scheme, colon, name = url.partition(":")
    if colon and name and scheme == "broker":
        from drivers.ports.broker import BrokerPort

        return BrokerPort(name)
    if colon and name and scheme == "socketcan":
        from drivers.ports.socketcan import SocketCanPort

        return SocketCanPort(name)
    raise PortError(f"{url!r}: a CAN port is broker:NAME or socketcan:INTERFACE, e.g. socketcan:can0")
