"""CAN ports that pass remote frames too, for nodes that answer them: emulated CANopen nodes (guarding, requested TPDOs).

A remote frame is received as a Frame whose identifier has bit 30 set (protocols.canopen.cob_id.REMOTE), as in struct can_frame.
"""

from drivers.ports.base import CanPort
from drivers.ports.can.broker import BrokerPort
from drivers.ports.can.open import open_can
from drivers.ports.can.wire import EFF_FLAG, ERR_FLAG


def open_can_with_remotes(url: str) -> CanPort:
    """As open_can; PortError when it cannot be opened."""
    port = open_can(url)
    if isinstance(port, BrokerPort):
        port.not_data = EFF_FLAG | ERR_FLAG
        return port
    from drivers.ports.can.socketcan import SocketCanPort

    if isinstance(port, SocketCanPort):
        port.not_data = EFF_FLAG | ERR_FLAG
    return port
