"""The sio variables in data and programs: each counts as linked while it exists (L2644-2648)."""

from collections.abc import Iterator

from gateway.pure.languages.val3.model import Type, UserType
from gateway.pure.languages.val3.values import Grid, SioV, UserV


def has_sockets(kind: Type) -> bool:
    """Whether values of a type are sio variables, or have some inside."""
    return any(has_sockets(each.type) for each in kind.fields.values()) if isinstance(kind, UserType) else kind == "sio"


def sockets_in(what: object) -> Iterator[SioV]:
    """All sio variables of a value or a container."""
    match what:
        case SioV():
            yield what
        case UserV():
            for name in what.names():
                yield from sockets_in(getattr(what, name))
        case Grid():
            yield from sockets_in(what.flat)
        case list() | dict():
            for each in what.values() if isinstance(what, dict) else what:
                yield from sockets_in(each)
