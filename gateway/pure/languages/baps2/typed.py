"""An expression with its type and its Python text.  Pure."""

from gateway.pure.languages.baps2.types import NONE, Type
from gateway.pure.languages.base.node import node


@node
class Typed:
    """An expression with its Python text.  `constant`: its value where it is known."""

    type: Type
    code: str
    constant: object = None
    truth: bool = False  # the text evaluates to True or False, not 1 or 0

    @property
    def value(self) -> str:
        """The text as a value that is stored."""
        return f"(1 if {self.code} else 0)" if self.truth else self.code


NOTHING = Typed(NONE, "None")


def numbers_text(parts: list[Typed]) -> str:
    """Python text of a point."""
    if all(isinstance(part.constant, int | float) for part in parts):
        return "(" + " ".join(f"{float(part.constant)!r}," for part in parts if isinstance(part.constant, int | float)) + ")"
    return "numbers_of((" + " ".join(f"{part.code}," for part in parts) + "))"
