"""Silences on an RTU line.  Source: MODBUS over Serial Line V1.02, section 2.5.1.1."""

from dataclasses import dataclass

from protocols.base.machine import Ns, ms

CHARACTER_BITS = 11  # start, 8 data, parity or a second stop bit, stop
FAST_BAUD = 19_200  # above it the silences are fixed
FAST_T15: Ns = 750_000
FAST_T35: Ns = 1_750_000


@dataclass(frozen=True, slots=True)
class Timing:
    """Meaning of silence; `char_ns` is the time of one character (0: no serial line, bytes come at any time)."""

    char_ns: Ns
    t15: Ns
    t35: Ns
    patience: Ns = 0  # added to t3.5 while a frame is incomplete: adapters and pipes pass bytes on in chunks (AX-344)
    strict: bool = False  # a gap above t1.5 inside a frame damages it; only if every byte has its own time (AX-344)

    @property
    def quiet(self) -> Ns:
        """Silence that must lie before a frame."""
        return self.t35


def timing(baud: int, bits: int = CHARACTER_BITS, patience: Ns = 0, strict: bool = False) -> Timing:
    """1.5 and 3.5 characters, above 19200 Bd the fixed 750 us and 1.75 ms."""
    char_ns = bits * 1_000_000_000 // baud
    if baud > FAST_BAUD:
        return Timing(char_ns, FAST_T15, FAST_T35, patience, strict)
    return Timing(char_ns, 3 * char_ns // 2, 7 * char_ns // 2, patience, strict)


OVER_TCP = Timing(char_ns=0, t15=ms(2000), t35=ms(2000))  # silence has no meaning there: lengths end a frame, the limit ends a half one
