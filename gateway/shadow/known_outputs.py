"""When a shadow may compare: its own state is known."""

from typing import TYPE_CHECKING

from gateway.pure.image.records.cell import AxisFlag
from protocols.base.machine import Ns, ms

if TYPE_CHECKING:
    from gateway.services.loop import Services

SETTLE: Ns = ms(5_000)


def state_is_known(services: "Services", since: Ns, now: Ns) -> bool:
    """The drives were heard; or they are silent for so long that this is the state."""
    axes = services.values.state.axes[: len(services.cell.axis)]
    unheard = AxisFlag.LOST | AxisFlag.UNCONFIGURED
    heard = bool(services.values.state.generation) and not any(axis.flags & unheard for axis in axes)
    return heard or now - since > SETTLE
