"""A [[line]] to the tables of its protocols: link profile, RK512 dialect, and the Bosch fault a failed BUEP64 job has."""

from dataclasses import replace
from enum import Enum
from typing import TypeVar

from gateway.pure.cell.cell import Choices, Line, Rk512, Times
from protocols.base.machine import Ns, ms
from protocols.buep64.faults import Cause, Fault, fault_of
from protocols.buep64.form import REACTION_WAIT, Form, Plc
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import BrokenPair, ConnectCounter, Interruption, Profile, Stray, TooLong, profile_named
from protocols.rk512.active import Denied, Failed, Trouble
from protocols.rk512.dialects import Dialect, dialect_of
from protocols.rk512.header import ErrorNumber

E = TypeVar("E", bound=Enum)
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
    """Profile and procedure (3964R or 3964) of the line; [line.times] and [line.choices] win over the profile (AX-250)."""
    profile = profile_named(line.profile, block_check=line.protocol != "3964")
    profile = replace(profile, follow_on_end=Char.ETB) if line.rk512.end_of_follow_on == "ETB" else profile
    return _chosen(_timed(profile, line.times), line.choices)


def _timed(profile: Profile, times: Times) -> Profile:
    return replace(
        profile,
        ack_delay=_ns(times.ack_delay, profile.ack_delay),
        char_delay=_ns(times.char_delay, profile.char_delay),
        block_wait=_ns(times.BWZ, profile.block_wait),
        retry_pause=_ns(times.pause, profile.retry_pause),
        no_buffer_wait=_ns(times.no_buffer, profile.no_buffer_wait),
        connect_attempts=times.connect_attempts or profile.connect_attempts,
        block_attempts=times.block_attempts or profile.block_attempts,
    )


def _ns(value_ms: int | None, profile_ns: Ns) -> Ns:
    return profile_ns if value_ms is None else ms(value_ms)


def _chosen(profile: Profile, choices: Choices) -> Profile:
    return replace(
        profile,
        connect_counter=_member(ConnectCounter, choices.connect_counter, profile.connect_counter),
        stray=_member(Stray, choices.stray, profile.stray),
        broken_pair=_member(BrokenPair, choices.broken_pair, profile.broken_pair),
        too_long=_member(TooLong, choices.too_long, profile.too_long),
        interruption=_member(Interruption, choices.interruption, profile.interruption),
        silence_ends=_given(choices.silence_ends, profile.silence_ends),
        yields_to_second_conflict=_given(choices.yields_to_second_conflict, profile.yields_to_second_conflict),
        nak_at_start=_given(choices.nak_at_start, profile.nak_at_start),
        nak_when_giving_up=_given(choices.nak_when_giving_up, profile.nak_when_giving_up),
    )


def _member(kind: type[E], word: str | None, usual: E) -> E:
    return usual if word is None else kind[word.upper()]


def _given(value: bool | None, usual: bool) -> bool:
    return usual if value is None else value


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
    if line.times.reaction is not None:
        dialect = replace(dialect, reaction_wait=ms(line.times.reaction))
    flag = (
        "serve" if given.coordination_flag == "keep" else given.coordination_flag
    )  # who resets it is the command source's business (AX-251)
    return replace(dialect, coordination_flag=flag, nesting=_given(line.choices.nesting, dialect.nesting))


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
