"""Bit numbers of the functions on the interface, edges and strobes.  Source: rho 3 Releases; table in rho3 3.1 and 3.2.

Numbers the manual leaves open are AX-531; the builder of the functions can pass them to `Places`.
"""

from dataclasses import dataclass

from gateway.pure.image.records.cell import InputImage, Quality, get_bit, set_bit
from protocols.base.machine import Ns, ms

STROBE_TIME: Ns = ms(200)  # P9 where the cell sets none (AX-530)


@dataclass(frozen=True, slots=True)
class Places:
    """Address of every signal of the functions; RC inputs first, then RC outputs."""

    display_off: int = 35  # DIS_PHGM_RCI (L949)
    phg_strobe: int = 49  # L4987
    phg_code: int = 56  # 4 bits (L4988-4991)
    msd_active: int = 60  # MSD_DISP_RCI (L871; D-03)
    abort_strobe: int = 80  # STBEXPS_RCI (L2628)
    select_strobe: int = 81  # ours, AX-531
    program_parity: int = 83  # PTY_EXTP_RCI (L2629)
    text_strobe: int = 85  # STB_TXTO_RCI (L948)
    program_code: int = 88  # 8 bits (L2630-2637)
    text_code: int = 104  # 8 bits (L950-952)
    statuses: int = 464  # USER_1_RCI..USER_99_RCI (L872-875)
    base_level: int = 104  # BASE_AC_RCO (L4995)
    text_ok: int = 108  # TXOUT_OK_RCO (L943)
    text_error: int = 109  # TXOUT_ER_RCO (L944)
    msd_open: int = 115  # MSD_ACTI_RCO (L867; D-02)
    aborted: int = 116  # L2641
    abort_error: int = 117  # L2643-2647
    error_strobe: int = 118  # STB_COER_RCO (L3024)
    error_parity: int = 119  # PTY_COER_RCO (L3025)
    selected: int = 120  # ours, AX-531
    select_error: int = 121  # ours, AX-531
    error_code: int = 152  # 16 bits (L3026-3029; D-05)


def number_at(image: bytes | bytearray, first: int, width: int) -> int:
    """`width` bits from bit `first` on, the first one weighing 1."""
    return sum(get_bit(image, first + step) << step for step in range(width))


def put_number(image: bytearray, first: int, width: int, value: int) -> None:
    """The reverse of number_at."""
    for step in range(width):
        set_bit(image, first + step, bool(value >> step & 1))


def trusted(inputs: InputImage, first: int) -> bool:
    """Return whether the byte of this bit comes from a live command source: an old code with a new strobe is not an order (AX-541)."""
    return inputs.quality[first >> 3] == Quality.GOOD


def even(value: int) -> bool:
    """The bit that makes the number of ones even (L3053-3055)."""
    return bool(value.bit_count() & 1)


class Edge:
    """Edges of one input bit.  The first level, also after the command source was lost, is not an edge: nothing starts unasked (AX-532)."""

    def __init__(self, bit: int) -> None:
        self._bit = bit
        self._last: bool | None = None

    def step(self, inputs: InputImage) -> int:
        """+1 rising, -1 falling, 0 neither."""
        if not trusted(inputs, self._bit):
            self._last = None
            return 0
        level, last = inputs.bit(self._bit), self._last
        self._last = level
        return 0 if last is None else int(level) - int(last)


class Pulse:
    """An output that is 1 for the strobe time P9; pulses follow each other with P9 of 0 between them."""

    def __init__(self, bit: int, strobe_time: Ns) -> None:
        self._bit, self._time = bit, strobe_time
        self._wanted = 0
        self._since: Ns | None = None
        self._high = False

    def give(self) -> None:
        """One more pulse; more than one waiting is one (a handshake has at most one answer open)."""
        self._wanted = 1

    def step(self, outputs: bytearray, now: Ns) -> None:
        """Sets the bit for this cycle."""
        if self._since is not None and now - self._since >= self._time:
            self._since = now if self._high else None
            self._high = False
        if self._since is None and self._wanted:
            self._wanted, self._high, self._since = 0, True, now
        set_bit(outputs, self._bit, self._high)
