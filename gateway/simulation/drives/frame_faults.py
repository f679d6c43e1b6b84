"""Commands to an emulator process that damage frames; socket and form as in gateway.simulation.drives.control.

    {"do": "drop", "way": "in", "id": 100, "count": 3}              three SYNCs do not come
    {"do": "delay", "way": "in", "id": 100, "ms": 1.5}              one SYNC comes late
    {"do": "duplicate", "way": "out", "id": 610, "count": 5}
    {"do": "corrupt", "way": "in", "id": 210, "byte": 3, "bits": 16}
    {"do": "quiet", "ms": 500}                                      bus-off: nothing in, nothing out
    {"do": "clear_frames"}

`id` may be left out: any frame.  `count` is 1 when left out.
"""

from drivers.emulator.wire.frame_faults import FrameFaults, Kind, Order, Way
from gateway.simulation.control_requests import Answer, BadCommandError, Command, whole
from protocols.base.machine import Ns, ms

MOST, LONGEST_MS = 1_000_000, 60_000.0
KINDS = {kind.value: kind for kind in Kind}
ORDERS = (*KINDS, "quiet", "clear_frames")


def carry_out_frames(faults: FrameFaults, command: Command, now: Ns) -> Answer:
    """Raises BadCommandError."""
    what = str(command.get("do"))
    if what == "clear_frames":
        faults.clear()
    elif what == "quiet":
        faults.quiet(now + ms(_number(command, "ms")))
    else:
        identifier = whole(command, "id", 0, 0x7FF) if "id" in command else None
        count = whole(command, "count", 1, MOST) if "count" in command else 1
        delay = ms(_number(command, "ms")) if KINDS[what] is Kind.DELAY else 0
        byte = whole(command, "byte", 0, 7) if "byte" in command else 0
        bits = whole(command, "bits", 1, 255) if "bits" in command else 1
        faults.order(Order(KINDS[what], _way(command), count, identifier, delay, byte, bits))
    return {"frames": {kind.value: number for kind, number in faults.spoilt.items()}}


def _way(command: Command) -> Way:
    try:
        return Way(command.get("way", "in"))
    except ValueError:
        raise BadCommandError(f"way: {command.get('way')!r}; in (to the drives) or out (from the drives)") from None


def _number(command: Command, key: str) -> float:
    value = command.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0.0 < value <= LONGEST_MS:
        raise BadCommandError(f"{key}: {value!r}; expected more than 0 and at most {LONGEST_MS:g} ms")
    return float(value)
