"""Devices in Python whose timers or supply are written plainly: what they leave out is not an error of the tester."""

import pathlib
import sys
from collections.abc import Sequence
from typing import cast

import pytest

from drivers.ports.base import PortError
from gateway.conformance.framework.bench_file import BadFile, Bench
from gateway.conformance.framework.machine import Guarded, GuardedFrames, load_machine
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner, ordered
from gateway.conformance.peers.score import with_preambles
from gateway.conformance.peers.stations import Built, fresh_link, link_of
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.registry import SUITES
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Machine, Ns
from protocols.p3964r.profiles import RHO3, Priority


class Plain(Built):
    """Off it does not wake, and its deadline stays where it was."""

    _off = False

    def power(self, on: bool, now: Ns) -> None:
        if on:
            fresh_link(self, self.priority)
        self._off = not on

    def wake(self, now: Ns) -> Sequence[object]:
        return [] if self._off else super().wake(now)


class StandsStill(Built):
    """Its deadline is never over, from the first STX on."""

    _heard = False

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._heard = True
        return super().receive(data, now)

    def deadline(self) -> Ns | None:
        return 0 if self._heard else super().deadline()


class Ticks(Built):
    """Looks at its line every 20 us."""

    _next: Ns = 0

    def wake(self, now: Ns) -> Sequence[object]:
        self._next = now + 20_000
        due = self.link.deadline()
        return super().wake(now) if due is not None and due <= now else []

    def deadline(self) -> Ns | None:
        return self._next


def _played(device: Built, only: Sequence[str]) -> dict[str, Result]:
    bench = Bench(None, "machine:own", link=link_of(RHO3, Priority.LOW))
    suite = SUITES["3964r"]

    def no_port(url: str, line_format: str) -> ToolPort:
        raise AssertionError(url)

    session = suite.session(Opened(bench, {}, no_port, make=lambda: Guarded(device, "own")))
    results = Runner(session, with_preambles(suite.purposes(), only)).run()
    return {result.purpose.id: result for result in results}


def test_a_machine_without_supply_may_leave_its_deadline_where_it_is() -> None:
    results = _played(Plain(), ("3964R_SUP_*",))
    assert {name: result.reason for name, result in results.items() if result.verdict is not Verdict.PASS} == {}


def test_a_deadline_that_does_not_move_is_a_fail_of_the_device_and_the_run_goes_on() -> None:
    results = _played(StandsStill(), ("3964R_RCV_BV_01", "3964R_RCV_BV_02"))
    assert {result.verdict for result in results.values()} == {Verdict.FAIL, Verdict.INCONC}
    assert "never passes" in results["3964R_RCV_BV_01"].reason


def test_a_machine_that_ticks_often_does_not_stand_still() -> None:
    """Some 150 000 times within one wait."""
    results = _played(Ticks(), ("3964R_RCV_TI_07",))
    assert {result.verdict for result in results.values()} == {Verdict.PASS}


def test_cases_that_switch_the_supply_come_last() -> None:
    for seed in (None, 1, 2):
        switching = ["power" in purpose.condition for purpose in ordered(SUITES["3964r"].purposes(), seed)]
        assert switching == sorted(switching)


class Nonsense:
    """A device whose methods give what they should not."""

    def __init__(self, due: object = None, said: object = b"") -> None:
        self._due, self._said = due, said

    def deadline(self) -> object:
        return self._due

    def take_output(self) -> object:
        return self._said

    def receive(self, data: bytes, now: Ns) -> None:
        sys.exit(3)


def wrong(due: object = None, said: object = b"") -> Machine[object]:
    return cast(Machine[object], Nonsense(due, said))


@pytest.mark.parametrize("due", ["soon", float("nan"), float("inf"), b"1"])
def test_a_deadline_that_is_no_time_is_named(due: object) -> None:
    with pytest.raises(PortError, match=r"deadline returned .*; nanoseconds expected, or None"):
        Guarded(wrong(due), "d.py:make").deadline()


def test_a_deadline_may_be_a_float() -> None:
    assert Guarded(wrong(2.5e8), "d.py:make").deadline() == 250_000_000
    assert Guarded(wrong(0.5), "d.py:make").deadline() == 1


def test_output_of_another_type_is_named_and_none_is_nothing() -> None:
    assert Guarded(wrong(said=None), "d").take_output() == b""
    assert GuardedFrames(Nonsense(said=None), "d").take_output() == []
    with pytest.raises(PortError, match="d: take_output returned 'x'; bytes expected"):
        Guarded(wrong(said="x"), "d").take_output()
    with pytest.raises(PortError, match=r"d: take_output returned b'x'; a list of pairs"):
        GuardedFrames(Nonsense(said=b"x"), "d").take_output()


def test_a_device_or_factory_that_exits_ends_itself_only(tmp_path: pathlib.Path) -> None:
    with pytest.raises(PortError, match="d: receive raised SystemExit: 3"):
        Guarded(wrong(), "d").receive(b"", 0)
    file = tmp_path / "d.py"
    file.write_text('import sys\ndef make():\n    sys.exit(3)\ndef odd():\n    raise ValueError("a\\nb")\n')
    with pytest.raises(BadFile, match="make raised SystemExit: 3; check its keys and values"):
        load_machine("machine:d.py:make", tmp_path)()
    with pytest.raises(BadFile, match="odd raised ValueError: a b; check"):
        load_machine("machine:d.py:odd", tmp_path)()
