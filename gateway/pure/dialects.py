"""A [[line]] to the tables of its protocols: link profile, RK512 dialect, and the Bosch fault a failed BUEP64 job has."""

from dataclasses import replace

from gateway.cell import Line, Rk512
from protocols.buep64.faults import Cause, Fault, fault_of
from protocols.buep64.form import REACTION_WAIT, Form, Plc
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import Profile, profile_named
from protocols.rk512.active import Denied, Failed, Trouble
from protocols.rk512.dialects import Dialect, dialect_of
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


def link_profile(line: Line) -> Profile:
    """Profile and procedure (3964R or 3964) of the line."""
    profile = profile_named(line.profile, block_check=line.protocol != "3964")
    return replace(profile, follow_on_end=Char.ETB) if line.rk512.end_of_follow_on == "ETB" else profile


def rk512_dialect(line: Line) -> Dialect:
    """The station's own dialect; what the file sets otherwise than its general default wins over it (AX-227)."""
    if line.layer == "buep64" or line.profile.removesuffix("-tcp") == BUEP64:
        dialect = buep64_dialect(Form())
    else:
        dialect = dialect_of(line.profile)
    given, usual = line.rk512, Rk512()
    if given.db_address_unit != usual.db_address_unit:
        dialect = replace(dialect, db_address_unit=given.db_address_unit, most_word=min(dialect.most_word, 127))
    if given.reaction != usual.reaction:
        dialect = replace(dialect, reaction=given.reaction)
    if given.unknown_block != usual.unknown_block:
        dialect = replace(dialect, unknown_block=given.unknown_block)
    return replace(dialect, coordination_flag=given.coordination_flag)


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


__all__ = ["BUEP64", "Plc", "buep64_dialect", "buep64_fault", "link_profile", "rk512_dialect"]
