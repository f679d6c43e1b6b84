"""Drive-on and disabled axes as the interface tells them.  Source: rho3 4.10 (L1295-1305, L7920-7941).

What an axis does with it is motion's part (motion.axes); here are the masks, bit n-1 for axis n.
"""

from gateway.pure.interface.image import PicImage

ALL_ON, FIRST_DRIVE, FIRST_DISABLED, AXES = 66, 192, 216, 20  # RC inputs
DISABLED_WARNING = 1408  # + axis - 1


def drive_on(image: PicImage, axes: int) -> int:
    """Axes whose drive is wanted on: all with the group signal, else those with their own."""
    every = (1 << axes) - 1
    return every if image.input(ALL_ON) else _mask(image, FIRST_DRIVE, axes)


class DisabledAxes:
    """Disabled at once with 1, enabled again only by a start of the control with 0."""

    def __init__(self, axes: int) -> None:
        """`axes` 1..20; ValueError otherwise."""
        if not 1 <= axes <= AXES:
            raise ValueError(f"{axes} axes: 1..{AXES}")
        self._axes = axes
        self.mask = 0

    def update(self, image: PicImage) -> tuple[int, ...]:
        """Looks at the signals; codes of the warnings of newly disabled axes."""
        new = _mask(image, FIRST_DISABLED, self._axes) & ~self.mask
        self.mask |= new
        return tuple(DISABLED_WARNING + number for number in range(self._axes) if new >> number & 1)


def _mask(image: PicImage, first: int, axes: int) -> int:
    return sum(image.input(first + number) << number for number in range(axes))
