"""What command sources of serial lines share, built alone: counters, faults in the journal, no port before the start."""

import json
import pathlib

import pytest

from gateway.runtime.journal import Journal
from gateway.services.context import RunContext
from gateway.services.sources.serial import SerialSource
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench
from protocols.base.machine import ms
from protocols.p3964r.events import SamePriority
from protocols.p3964r.profiles import Priority


class Counting(SerialSource):
    """A source of a line that only counts."""

    counted = ("bad_blocks",)


@pytest.fixture
def journal(tmp_path: pathlib.Path) -> pathlib.Path:
    return tmp_path / "journal.jsonl"


def texts(journal: pathlib.Path) -> list[str]:
    return [json.loads(line)["text"] for line in journal.read_text().splitlines()]


def made(bench: SourceBench, journal: pathlib.Path) -> Counting:
    bench.run = RunContext(bench.run.cell, bench.plan, Journal(journal, "services"), bench.run.recorder, bench.run.clock)
    return Counting(bench.context("plc1"), DEMO.line[0])


def test_faults_are_counted_each_and_written_to_the_journal_once_a_second(journal: pathlib.Path) -> None:
    bench = SourceBench(DEMO)
    source = made(bench, journal)
    for now in (0, ms(400), ms(999), ms(1000)):
        source._fault("bad_blocks", f"at {now}", now)
    assert source.counters()["bad_blocks"] == 4
    assert texts(journal)[1:] == ["plc1: at 0", f"plc1: at {ms(1000)}"]
    bench.close()


def test_stations_of_the_same_priority_are_one_advice(journal: pathlib.Path) -> None:
    bench = SourceBench(DEMO)
    source = made(bench, journal)
    source._link_fault(SamePriority(Priority.LOW), 0)
    assert source.counters()["same_priority"] == 1 and "set one to high" in str(source.counters()["advice"])
    bench.close()


def test_before_its_start_it_has_no_port_and_nothing_has_passed(journal: pathlib.Path) -> None:
    bench = SourceBench(DEMO)
    source = made(bench, journal)
    assert (source.connected, source.passed(0), source.row()["connected"]) == (False, None, False)
    bench.close()


def test_a_silent_partner_is_a_loss_after_the_time_of_its_watch(journal: pathlib.Path) -> None:
    bench = SourceBench(DEMO)
    source = made(bench, journal)
    source.heard(0)
    source.step(ms(499))
    assert source.watch.alive
    source.step(ms(501))
    assert not source.watch.alive and source.row()["losses"] == 1
    assert texts(journal)[-1].startswith("command source 1 plc1: silent for 500 ms; stop_on_path")
    bench.close()
