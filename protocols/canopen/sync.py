"""SYNC on the wire.  Source: CiA 301, 7.2.5 and object 1019h."""

from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid

COUNTER_RANGE = (2, 240)  # of 1019h; 0: no counter


def frame(counter: int | None = None) -> Frame:
    return Frame(cobid.SYNC, b"" if counter is None else bytes((counter,)))


def following(counter: int, overflow: int) -> int:
    """The counter of the next SYNC: 1..overflow."""
    return 1 if counter >= overflow else counter + 1
