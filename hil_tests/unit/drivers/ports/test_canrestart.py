"""The netlink message that restarts a CAN controller, octet by octet from rtnetlink(7) and linux/can/netlink.h."""

from drivers.ports.can.restart import message


def test_the_message() -> None:
    words = (
        "38000000 1000 0500 01000000 00000000"  # 56 octets, RTM_NEWLINK, request and acknowledge, sequence 1, port 0
        "00 00 0000 07000000 00000000 00000000"  # AF_UNSPEC, interface 7, no flags, no change
        "1800 1200"  # IFLA_LINKINFO
        "0800 0100 63616e00"  # kind "can"
        "0c00 0200 0800 0800 01000000"  # data: IFLA_CAN_RESTART 1
    )
    assert message(7) == bytes.fromhex(words.replace(" ", ""))
