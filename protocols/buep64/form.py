"""Bosch BUEP64: RK512's telegrams with its own limits, times and ends.  Source: R500 interface manual 1070 072 131-102, chapter 9.

RST is the requesting station, PST the answering one, DM a data module, "transfer completion sequence" a follow-on telegram.  The fault
numbers of the PST's response are on pages that could not be read [open]: those of RK512 are used (AX-226).
"""

from dataclasses import dataclass
from enum import Enum

from protocols.base.machine import Ns, ms
from protocols.buep64.faults import Cause, Fault, fault_of

MOST_BYTES = 512  # of one job, 128 of them in one telegram
REACTION_WAIT = ((110, 20_000), (150, 15_000), (300, 10_000), (600, 7_000), (1 << 30, 5_000))  # up to this baud rate: ms
MOST_DM = 255


class Plc(Enum):
    """The Bosch control on the line; the value is its highest word number in a DM."""

    CL500 = 255  # R500, CL400: the byte address in the DM is twice the word number
    CL300 = 127


@dataclass(frozen=True, slots=True)
class Form:
    """How this station uses RK512's telegrams."""

    plc: Plc = Plc.CL500
    etb: bool = False  # completion sequences end with DLE ETB (switch; CL300 and PC600 send ETX and accept both)
    kinds: bytes = b"D"  # data modules only, operand type fixed to word
    most_bytes: int = MOST_BYTES
    nesting: bool = False  # a request that arrives instead of the response ends the own job with a fault

    def fault_of_job(self, dm: int, word: int, words: int) -> Fault | None:
        """Answer of the RST itself to a job before anything is sent; None: it may go."""
        if not 0 <= dm <= MOST_DM:
            return fault_of(Cause.DM_NUMBER)
        if not 0 <= word <= self.plc.value:
            return fault_of(Cause.PARTNER_ADDRESS)
        if not 1 <= words <= self.most_bytes // 2:
            return fault_of(Cause.AMOUNT)
        return None


def reaction_wait(baud: int) -> Ns:
    """Longest wait for the response by the speed of the line."""
    return ms(next(time for limit, time in REACTION_WAIT if baud <= limit))
