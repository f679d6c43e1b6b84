"""When a shadow may compare: its own state is known."""

from gateway.pure.image.records.cell import AxisFlag
from gateway.services.shared_image import SharedImage
from protocols.base.machine import Ns, ms

SETTLE: Ns = ms(5_000)


def state_is_known(image: SharedImage, count: int, since: Ns, now: Ns) -> bool:
    """`count`: axes of the cell.  Telegrams of the drives were received, or the drives have been silent so long that this is the state."""
    axes = image.state.axes[:count]
    unheard = AxisFlag.LOST | AxisFlag.UNCONFIGURED
    heard = bool(image.state.generation) and not any(axis.flags & unheard for axis in axes)
    return heard or now - since > SETTLE
