"""A [[line]] to the profile of its link."""

from dataclasses import replace
from enum import Enum
from typing import TypeVar

from gateway.pure.cell.cell import Choices, Line, Times
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import BrokenPair, ConnectCounter, Interruption, Profile, Stray, TooLong, profile_named

E = TypeVar("E", bound=Enum)


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
