"""BLOCK_SEARCH: how far ahead of the block under way stretches may be planned (AX-587).  Pure."""

from collections.abc import Sequence

from motion.planner.stretch import Stretch


def within_search(fresh: Sequence[Stretch], under_way: int) -> int:
    """How many of these, in their order, may be planned while the block `under_way` is run."""
    behind = (n for n, each in enumerate(fresh) if each.source.ahead and each.last - under_way > each.source.ahead)
    return next(behind, len(fresh))


def few_are_new(fresh: Sequence[Stretch], ready: int) -> bool:
    """Return whether fewer than half of the held-back blocks are new: one tail per block would overload the cycle's ring."""
    first, last = fresh[0], fresh[ready - 1]
    return ready < len(fresh) and 2 * (last.last - first.last + 1) < last.source.ahead
