"""RK512 passive: whatever a partner breaks off, and however soon it sends its next command, each reaction answers its own (AX-650)."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from gateway.pure.lines.rk512_link import Rk512Link
from hil_tests.lab.partners.blunt_plc import BluntPlc, Job
from hil_tests.lab.virtual.rk512_blocks import Blocks
from hil_tests.lab.virtual.virtual_line import VirtualLine
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import RHO3, SIEMENS_CP341, Priority, Profile

WORDS = 100
OUTCOMES = ("take", "leave", "torn", "unacknowledged")


def fetch(block: int, word: int, words: int = 1) -> bytes:
    return bytes((0, 0, 0x45, 0x44, block, word)) + words.to_bytes(2, "big") + b"\xff\xff"


def send(block: int, word: int, value: int) -> bytes:
    return bytes((0, 0, 0x41, 0x44, block, word, 0, 1, 0xFF, 0xFF)) + value.to_bytes(2, "big")


def fits(command: bytes, reaction: bytes | None) -> bool:
    """Only the reaction to this very command passes: every word of DB 5 tells where it is, DB 99 is missing."""
    if reaction is None:
        return False
    if command[4] == 99:
        return reaction == b"\0\0\0\x14"
    if command[2] == 0x41:
        return reaction == bytes(4)
    words = min(int.from_bytes(command[6:8], "big"), 64)
    return reaction == bytes(4) + b"".join(bytes((0xD0, command[5] + at)) for at in range(words))


COMMANDS = st.one_of(
    st.builds(fetch, st.sampled_from([5, 5, 99]), st.integers(0, 30), st.sampled_from([1, 2, 3, 64])),
    st.builds(send, st.sampled_from([7, 99]), st.integers(0, 30), st.integers(0, 0xFFFF)),
)
PAUSES = st.one_of(st.just(0), st.integers(0, ms(50)), st.integers(0, ms(700)), st.integers(0, ms(20_000)))
JOBS = st.lists(st.builds(Job, COMMANDS, st.sampled_from(OUTCOMES), PAUSES), min_size=1, max_size=6)
LONG = Job(fetch(5, 0, 70), "leave")


def meet(jobs: list[Job], ours: Priority, profile: Profile, char_time: Ns = 11_000_000_000 // 9600) -> BluntPlc:
    store = Blocks({5: WORDS, 7: WORDS})
    store.blocks[5][:] = b"".join(bytes((0xD0, word)) for word in range(WORDS))
    plc = BluntPlc([*jobs, Job(fetch(5, 42))], priority=ours is Priority.LOW)
    line = VirtualLine[object](Rk512Link(profile, ours, store), plc, lambda side, event, now: None, char_time=char_time, burst=1)
    line.kick(0)
    line.kick(1)
    while not plc.over and line.now < ms(3_600_000):
        line.step()
    return plc


@pytest.mark.parametrize("profile", [RHO3, SIEMENS_CP341], ids=lambda profile: str(profile.name))
@pytest.mark.parametrize("ours", list(Priority))
@settings(max_examples=150, deadline=None)
@given(JOBS)
@example([Job(send(99, 0, 1), "leave"), Job(send(7, 0, 1))])
@example([Job(fetch(5, 1), "leave"), Job(fetch(5, 2)), Job(fetch(5, 3)), Job(fetch(5, 4))])
def test_each_reaction_answers_its_own_command(profile: Profile, ours: Priority, jobs: list[Job]) -> None:
    plc = meet(jobs, ours, profile)
    assert plc.over and all(plc.answers.values()), "a command was not answered"
    wrong = {number: reaction for number, reaction in plc.answers.items() if not fits(plc.jobs[number].command, reaction)}
    assert not wrong, f"{wrong} of {plc.jobs}"
    assert set(plc.answers) == {number for number, job in enumerate(plc.jobs) if job.ends == "take"}


@pytest.mark.parametrize("pause", [0, ms(300), ms(5000)])
def test_a_plc_that_starts_again_in_a_long_job_gets_no_sequence_error(pause: Ns) -> None:
    plc = meet([Job(LONG.command, "leave", pause)], Priority.LOW, RHO3)
    assert plc.answers[1] == b"\0\0\0\0\xd0\x2a"
