"""Channels the tests declare."""

from dataclasses import replace

from gateway.pure.controllers.val3.sio.channel import Channel, Kind

SERIAL = Channel("Serial\\1", Kind.SERIAL, device="/dev/ttyS0")
CLIENT = Channel("Socket\\client", Kind.TCP_CLIENT, description="to the camera", address="192.168.0.254", port=4000)
SERVER = Channel("Socket\\server", Kind.TCP_SERVER, port=4001, clients=2)
UDP = Channel("Socket\\udp", Kind.UDP, address="192.168.0.7", port=4002)


def with_timeout(channel: Channel, seconds: float) -> Channel:
    """The same with another time-out."""
    return replace(channel, timeout_s=seconds)
