"""BUEP64 as a dialect of RK512, and the fault a Bosch PLC shows for a failed job."""

from protocols.buep64.faults import Cause, Fault, fault_of
from protocols.buep64.form import REACTION_WAIT, Form
from protocols.rk512.active import Denied, Failed, Trouble
from protocols.rk512.dialects import Dialect
from protocols.rk512.header import ErrorNumber

BUEP64 = "bosch-buep64"
CAUSES = {
    Trouble.LINK: Cause.ATTEMPTS,
    Trouble.NO_REACTION: Cause.TIME,
    Trouble.COMMAND_INSTEAD: Cause.OPENING,
    Trouble.TOO_MUCH_DATA: Cause.AMOUNT,
    Trouble.TOO_LITTLE_DATA: Cause.AMOUNT,
    Trouble.DATA_AFTER_SEND: Cause.AMOUNT,
}


def buep64_dialect(form: Form) -> Dialect:
    """BUEP64 as a dialect of RK512."""
    return Dialect(
        BUEP64,
        "Bosch R500 interface manual 1070 072 131-102, chapter 9",
        send_kinds=form.kinds,
        most_bytes=form.most_bytes,
        served_bytes=form.most_bytes,
        most_word=form.plc.value,
        nesting=form.nesting,
        by_speed=REACTION_WAIT,
    )


def buep64_fault(event: Failed | Denied) -> Fault:
    """What a Bosch PLC shows where our own job failed."""
    if isinstance(event, Denied):
        return fault_of(Cause.PARTNER_DM if event.number in (ErrorNumber.BLOCK, ErrorNumber.NOT_ALLOWED) else Cause.NOT_READABLE)
    return fault_of(CAUSES.get(event.why, Cause.NOT_READABLE))
