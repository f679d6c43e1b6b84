"""From frames to a proposal: both byte orders are tried, the one that explains more is taken."""

from collections.abc import Sequence

from gateway.pure.buses.inference.missing import no_cycle
from gateway.pure.buses.inference.roles import Inferred, infer
from gateway.pure.buses.inference.series import cut
from gateway.pure.buses.inference.signals import explained
from protocols.base.machine import Frame

MARGIN = 1.05  # low byte first unless the other order explains clearly more


class NothingFound(ValueError):
    """The recording has no cycle of at least 100 messages, or nothing in it moves."""


def propose(frames: Sequence[Frame]) -> Inferred:
    """Raises NothingFound."""
    plain, backwards = cut(frames, reverse=False), cut(frames, reverse=True)
    if plain is None or backwards is None or not plain.messages:
        raise NothingFound(no_cycle(frames))
    reverse = explained(backwards) > MARGIN * explained(plain)
    return infer(backwards if reverse else plain, reverse)
