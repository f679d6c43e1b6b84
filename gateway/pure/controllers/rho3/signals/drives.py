"""Drive-on and disabled axes as commanded by the interface.  Source: rho3 4.10 (L1295-1305, L7920-7941), AX-333.

What an axis does with it is motion's part (motion.axes); here are the masks, bit n-1 for axis n, and what changes in them asks for.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gateway.pure.controllers.pic_image import PicImage

ALL_ON, FIRST_DRIVE, FIRST_DISABLED, AXES = 66, 192, 216, 20  # RC inputs; axes after the 20th have only the group signal (AX-572)
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


@dataclass(slots=True)
class Asked:
    """What one command source asks for with its drive-on signals in this cycle; masks of axes."""

    on: int = 0
    off: int = 0


@dataclass(slots=True)
class _Axis:
    before: bool = True  # a level set at the first look is not an edge
    mine: bool = False  # its signal has been set: its falling edge switches it off


class DriveOn:
    """Edges of the drive-on signals, command source by command source; a signal already set at start or when its command source comes
    back starts nothing."""

    def __init__(self, axes: int, owner_of: Callable[[int], int]) -> None:
        """`owner_of`: RC input byte -> number of the command source that writes it, 0: none."""
        self._axes = [_Axis() for _ in range(axes)]
        self._owner_of = owner_of
        self._group = owner_of(ALL_ON >> 3)

    def look(self, image: PicImage) -> Mapping[int, Asked]:
        """Once per cycle: command source -> what it asks for."""
        asked: dict[int, Asked] = {}
        for number, axis in enumerate(self._axes):
            place = FIRST_DRIVE + number
            has_own = number < AXES
            own = self._owner_of(place >> 3) if has_own else 0
            group = image.input(ALL_ON)
            level = group or (has_own and image.input(place))
            known = [bit for bit, owner in ((ALL_ON, self._group), (place, own)) if owner]
            trusted = bool(known) and all(image.trusted(bit) for bit in ([ALL_ON] if group else known))
            rises, falls = trusted and level and not axis.before, trusted and not level and axis.mine
            axis.before = level or not trusted
            axis.mine = level if trusted else axis.mine
            source = self._group if group or not own else own
            if rises:
                asked.setdefault(source, Asked()).on |= 1 << number
            elif falls:
                asked.setdefault(source, Asked()).off |= 1 << number
        return asked

    @property
    def wanted(self) -> int:
        """Axes whose signal has been set since its last edge."""
        return sum(axis.mine << number for number, axis in enumerate(self._axes))
