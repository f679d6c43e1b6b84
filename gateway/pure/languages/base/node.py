"""Nodes of a tree that a reader makes by the hundred thousand."""

from dataclasses import dataclass, field
from typing import TypeVar, dataclass_transform

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def node(cls: type[T]) -> type[T]:
    """A frozen dataclass for the type checker, which refuses every assignment to a field.  At run time it has no such guard, because that
    makes each of the many nodes four times as dear."""
    return dataclass(slots=True, unsafe_hash=True)(cls)
