"""Blocks we send: built out of fixed bytes and named values, at the edge of a value."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from protocols.base.errors import EncodeError
from protocols.telegrams.fields import Field, Value, encode
from protocols.telegrams.layout import Outgoing


def build(telegram: Outgoing, lookup: Callable[[str], Value]) -> bytes:
    """The block of this moment.  EncodeError names telegram, value and range; `lookup` raises KeyError for a name without a value."""
    block = b"".join(part if isinstance(part, bytes) else _value(telegram, part, lookup) for part in telegram.parts)
    if not 1 <= len(block) <= telegram.most:
        raise EncodeError(f"{telegram.name}: {len(block)} bytes, range 1..{telegram.most}")
    return block


def _value(telegram: Outgoing, field: Field, lookup: Callable[[str], Value]) -> bytes:
    try:
        return encode(field, lookup(field.name))
    except KeyError as error:
        raise EncodeError(f"{telegram.name}: {field.name} has no value yet") from error
    except EncodeError as error:
        raise EncodeError(f"{telegram.name}: {error}") from error


class Edge(Enum):
    """Which change of a value sends; the value is the word of the cell file."""

    RISING = "rising"
    FALLING = "falling"
    CHANGE = "change"


@dataclass(frozen=True, slots=True)
class When:
    """`when = "rising order.done"`."""

    edge: Edge
    name: str


def parse_when(text: str) -> When | None:
    """None when the text has no such part."""
    words = text.split()
    edges = {edge.value: edge for edge in Edge}
    return When(edges[words[0]], words[1]) if len(words) == 2 and words[0] in edges else None


class EdgeWatch:
    """One `when`.  The first value seen only sets the state: a bit already set sends nothing (AX-194)."""

    def __init__(self, when: When) -> None:
        self.when = when
        self._last: Value | None = None

    def fires(self, value: Value | None) -> bool:
        """Call with each new value; None: there is none (yet), which changes nothing."""
        last, self._last = self._last, self._last if value is None else value
        if last is None or value is None:
            return False
        if self.when.edge is Edge.CHANGE:
            return value != last
        return bool(value) is (self.when.edge is Edge.RISING) and bool(last) is not bool(value)
