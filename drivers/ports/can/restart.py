"""Restarts a CAN controller of the kernel after bus-off, like `ip link set can0 type can restart`, by one netlink message.

Source: rtnetlink(7); linux/if_link.h (IFLA_LINKINFO, IFLA_INFO_KIND, IFLA_INFO_DATA); linux/can/netlink.h (IFLA_CAN_RESTART); AX-437.
"""

import contextlib
import errno
import socket
import struct

HEADER, ANSWER = struct.Struct("=IHHII"), struct.Struct("=i")  # length, type, flags, sequence, port; then its error number, negative
LINK = struct.Struct("=BxHiII")  # family, type, index, flags, change
ATTRIBUTE = struct.Struct("=HH")  # length, type
RTM_NEWLINK, NLMSG_ERROR, NLM_F_REQUEST, NLM_F_ACK = 16, 2, 1, 4
IFLA_LINKINFO, INFO_KIND, INFO_DATA, CAN_RESTART = 18, 1, 2, 8
PATIENCE_S = 0.05


def restart(interface: str) -> int:
    """0: restarted; else an error number: EBUSY it is not bus-off, EPERM not permitted (CAP_NET_ADMIN), EOPNOTSUPP none of metal (vcan)."""
    try:
        index = socket.if_nametoindex(interface)
    except OSError as error:
        return error.errno or errno.ENODEV
    request = message(index)
    with contextlib.suppress(OSError), socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, socket.NETLINK_ROUTE) as link:
        link.settimeout(PATIENCE_S)
        link.send(request)
        answer = link.recv(4096)
        if HEADER.unpack_from(answer)[1] == NLMSG_ERROR:
            return -int(ANSWER.unpack_from(answer, HEADER.size)[0])
    return errno.EIO


def message(index: int) -> bytes:
    """The request for the interface of that index."""
    data = _attribute(INFO_KIND, b"can\0") + _attribute(INFO_DATA, _attribute(CAN_RESTART, struct.pack("=I", 1)))
    body = LINK.pack(socket.AF_UNSPEC, 0, index, 0, 0) + _attribute(IFLA_LINKINFO, data)
    return HEADER.pack(HEADER.size + len(body), RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK, 1, 0) + body


def _attribute(kind: int, payload: bytes) -> bytes:
    return ATTRIBUTE.pack(ATTRIBUTE.size + len(payload), kind) + payload + bytes(-len(payload) % 4)
