"""Requests of the core to its adapter.  Connections are distinguished by number; a number is never used again, except a serial line's."""

from dataclasses import dataclass

from gateway.pure.controllers.val3.sio.channel import Channel


@dataclass(frozen=True, slots=True)
class Open:
    """Connect, bind or open the line once; answer `opened` or `refused`."""

    number: int
    channel: Channel


@dataclass(frozen=True, slots=True)
class Listen:
    """Wait for clients; each is offered by `accepted`.  Answer `not_listening` when the port cannot be had."""

    channel: Channel


@dataclass(frozen=True, slots=True)
class StopListening:
    name: str  # of the channel


@dataclass(frozen=True, slots=True)
class Close:
    number: int


@dataclass(frozen=True, slots=True)
class Configure:
    """The channel's parameters have changed under an open connection."""

    number: int
    channel: Channel


Order = Open | Listen | StopListening | Close | Configure
