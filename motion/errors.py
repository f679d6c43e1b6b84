"""What callers of the motion core do wrong: one base class, messages that name axis, value, range and unit."""


class MotionError(Exception):
    """Base of every exception of the motion core."""


class LimitError(MotionError):
    """A value outside the limits of an axis; the attributes hold the details for displays that show more than the text."""

    def __init__(self, axis: str, quantity: str, value: float, lower: float, upper: float, unit: str) -> None:
        self.axis, self.quantity, self.value = axis, quantity, value
        self.lower, self.upper, self.unit = lower, upper, unit
        suffix = f" {unit}" if unit else ""
        super().__init__(f"axis {axis}: {quantity} {value:.6g}{suffix} is outside {lower:.6g} .. {upper:.6g}{suffix}")


class PieceError(MotionError):
    """A piece of path that cannot be taken: malformed, or not where the axes are."""


class LatePieceError(PieceError):
    """It would replace pieces of which some have begun."""
