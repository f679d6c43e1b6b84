"""Our own SEND and FETCH of a line: due in time, one of each on the way, changes sent once; and a passive line has none."""

import pytest

from gateway.pure.arbitration.block_keys import block_key, block_name
from gateway.pure.arbitration.own_jobs import AGAIN, OwnJob, OwnJobs
from gateway.pure.cell.cell import Line, Rk512
from gateway.pure.image.reasons import CommandState
from gateway.services.sources.rk512 import NotActive, Rk512Source
from hil_tests.unit.gateway.pure.arbitration.test_data_blocks import BlockBench as DataBlockBench
from protocols.base.machine import Ns, ms
from protocols.rk512.flags import Flags
from protocols.rk512.header import Flag, Kind

SEND = OwnJob(11, False, Kind.BLOCK, 20, 0, 4, every=ms(100))
FETCH = OwnJob(10, True, Kind.BLOCK, 21, 0, 4, every=ms(250))
CHANGE = OwnJob(12, False, Kind.BLOCK, 22, 0, 4, on_change=True)


class Sender:
    """Gives what is due and remembers it."""

    def __init__(self, *jobs: OwnJob) -> None:
        self.jobs, self.data, self.number = OwnJobs(jobs), b"\0\0", 0

    def at(self, now: Ns) -> list[OwnJob]:
        given = []
        for job, data in self.jobs.due(now, lambda key: self.data):
            self.number += 1
            self.jobs.given(self.number, job, data, now)
            given.append(job)
        return given


def test_each_job_comes_at_its_own_interval_and_keeps_its_phase() -> None:
    sender = Sender(SEND, FETCH)
    given = {0: sender.at(0)}
    for now in range(5, 505, 5):
        for number in (*sender.jobs._open,):
            sender.jobs.over(number)
        if found := sender.at(ms(now)):
            given[now] = found
    assert given == {0: [SEND, FETCH], 100: [SEND], 200: [SEND], 250: [FETCH], 300: [SEND], 400: [SEND], 500: [SEND, FETCH]}


def test_a_job_is_never_on_its_way_twice_and_what_was_missed_is_not_made_up_for() -> None:
    sender = Sender(SEND)
    assert sender.at(0) == [SEND]
    assert sender.at(ms(450)) == []
    assert sender.jobs.over(1) == SEND
    assert sender.at(ms(450)) == [SEND]
    sender.jobs.over(2)
    assert sender.at(ms(495)) == []
    assert sender.at(ms(500)) == [SEND], "the phase is kept"


def test_a_change_is_sent_once_and_again_only_a_while_after_it_failed() -> None:
    sender = Sender(CHANGE)
    assert sender.at(0) == [CHANGE], "the partner has nothing yet"
    sender.jobs.over(1)
    assert sender.at(ms(5)) == []
    sender.data = b"\0\1"
    assert sender.at(ms(10)) == [CHANGE]
    assert sender.jobs.failed(2, ms(20)) == CHANGE
    assert sender.at(ms(25)) == [], "a partner that refuses is not flooded"
    assert sender.at(ms(20) + AGAIN) == [CHANGE]


def test_an_answer_to_nobody_s_job_is_told_apart() -> None:
    sender = Sender(SEND)
    assert sender.jobs.over(9) is None
    assert sender.jobs.failed(9, 0) is None


def test_a_passive_line_has_no_jobs_of_its_own() -> None:
    source = Rk512Source.__new__(Rk512Source)
    source.name, source.line = "plc", Line("plc", "sim", role="passive")
    with pytest.raises(NotActive, match='role = "passive"'):
        source.active  # noqa: B018


def test_a_coordination_flag_falls_when_the_move_it_came_with_has_ended() -> None:
    source = Rk512Source.__new__(Rk512Source)
    source.line, source.flags, source.data = Line("plc", "sim", rk512=Rk512(coordination_flag="serve")), Flags(), DataBlockBench().source
    flag = Flag(6, 4)
    source.flags.take(flag)
    source.data.move_state(CommandState.RUNNING)
    source.reset_used_flags()
    assert source.flags.locks(flag), "the move is under way"
    source.data.move_state(CommandState.DONE)
    source.reset_used_flags()
    assert not source.flags.locks(flag)
    for kept in ("keep", "ignore", "refuse"):
        source.line = Line("plc", "sim", rk512=Rk512(coordination_flag=kept))
        source.flags.take(flag)
        source.reset_used_flags()
        assert source.flags.locks(flag), f"{kept}: nobody resets it by himself"


def test_blocks_and_areas_have_one_key_each() -> None:
    assert (block_key("D", 10), block_key("X", 10), block_key("M", 0)) == (10, 266, 1024)
    assert [block_name(key) for key in (10, 266, 1024)] == ["DB 10", "DX 10", "area M"]
    assert len({block_key(kind, number) for kind in "DX" for number in range(1, 256)} | {block_key(kind, 0) for kind in "EAMTZ"}) == 515
