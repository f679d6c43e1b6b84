"""A jog key of the page in a cell with P113 and P114: page, services, cycle and drives in virtual time."""

import asyncio
import re
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest

from gateway.assembly.jog import Jog, jog_of
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.observer.regions import Regions
from gateway.observer.tool_link import ServicesLink
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cell.web import PAGE_SOURCE
from gateway.services.canopen import CanopenServices
from gateway.services.tool_interface import ToolInterface
from gateway.web import operator_control
from gateway.web.operator_control import OperatorControl
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.source_bench import SourceBench

DEMO = read_text(find_config("demo", "cells"))
SLOW, FAST = 12.0, 40.0  # mm/s or deg/s of every axis
SPEEDS = "[rho3]\nP113 = [{}]\nP114 = [{}]\n".format(*(", ".join([str(speed)] * 6) for speed in (SLOW, FAST)))


class Link:
    """The way from the page to the services."""

    def __init__(self, tool: ToolInterface) -> None:
        self._tool = tool

    async def ask(self, op: str, **rest: object) -> dict[str, object]:
        answer = self._tool.answer({"op": op, **rest}, "page")
        assert answer is not None and "error" not in answer, answer
        return answer

    async def command(self, code: str, mask: int = 0, **rest: object) -> dict[str, object]:
        return await self.ask("tool", code=code, mask=mask, **rest)


class Page:
    """speeds: mm/s or deg/s of axis 1, a value a cycle."""

    def __init__(self, patch: pytest.MonkeyPatch, more: str) -> None:
        cell = load_cell("jog.toml", DEMO + more)
        self.cell = CellBench(cell=cell).ready()
        self.cell.settle(self.cell.give(Code.RELEASE_CONTROL))
        self.bench = SourceBench(cell, clock=lambda: self.cell.now)
        tool = ToolInterface(
            self.bench.run,
            self.bench.image,
            self.cell.dispatcher,
            CanopenServices(self.bench.plan, self.bench.fds, self.bench.run.journal.write),
            PAGE_SOURCE,
            "page",
        )
        facts = [(axis.name, axis.unit, fact.si) for axis, fact in zip(cell.axis, self.cell.dispatcher.axes, strict=True)]
        regions = SimpleNamespace(look=lambda: None, state=self.cell.core.state, facts=facts)
        patch.setattr(operator_control, "time", SimpleNamespace(monotonic=lambda: self.cell.now * 1e-9))
        self.operator_control = OperatorControl(cast(ServicesLink, Link(tool)), cast(Regions, regions), cell.axis, jog_of(cell))
        asyncio.run(self.operator_control.command("me", "me", "request_control"))
        self.cell.run(0.2)
        self.speeds: list[float] = []

    def hold(self, seconds: float, percent: float = 10.0) -> None:
        """The key of axis 1, plus, a sign of it each 0.1 s."""
        for turn in range(round(seconds * 10)):
            asyncio.run(self.operator_control.jog("me", 0, 1, percent, first=turn == 0))
            self.cell._hand_over()
            for _ in range(25):
                before = self.cell.set()[0]
                self.cell.cycle()
                self.speeds.append((self.cell.set()[0] - before) / 0.004)

    def close(self) -> None:
        self.bench.close()


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    made = Page(monkeypatch, SPEEDS)
    yield made
    made.close()


@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:JogKeys.wanted")
@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:manual_speed")
def test_a_key_moves_slowly_and_fast_from_1_5_s_on(page: Page) -> None:
    page.hold(3.0)
    slow, fast = page.speeds[100:370], page.speeds[450:740]
    assert slow == pytest.approx([SLOW] * len(slow), abs=0.01), "until 1.5 s"
    assert fast == pytest.approx([FAST] * len(fast), abs=0.01) and max(page.speeds) <= FAST + 0.01, "then P114, and never more"


def test_pressed_anew_it_is_slow_again_and_the_pages_speed_is_a_share(page: Page) -> None:
    page.hold(2.0)
    asyncio.run(page.operator_control.command("me", "me", "stop"))
    page.cell._hand_over()
    page.cell.run(1.0)
    asyncio.run(page.operator_control.command("me", "me", "abandon"))
    page.cell._hand_over()
    page.cell.run(0.2)
    page.speeds.clear()
    page.hold(1.0, percent=5.0)
    assert page.speeds[150:240] == pytest.approx([SLOW / 2.0] * 90, abs=0.01)


@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:SlopeParameters.jogging")
def test_its_slope_is_p128_and_p104_where_that_is_not_set() -> None:
    cell = load_cell("jog.toml", DEMO + SPEEDS)
    accel = cell.axis[0].limits.accel
    slopes = (
        "P128 = ["
        + ", ".join(str(accel / 4.0) if number == 0 else str(axis.limits.accel * 2.0) for number, axis in enumerate(cell.axis))
        + "]\n"
    )
    plain, given = jog_of(cell), jog_of(load_cell("jog.toml", DEMO + SPEEDS + slopes))
    assert isinstance(plain, Jog) and isinstance(given, Jog)
    assert [plain.acceleration(0), given.acceleration(0), given.acceleration(1)] == pytest.approx([1.0, 0.25, 1.0])


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ((f"P114 = [{FAST}", "P114 = [5.0"), "P113/P114 of axis 1: slow"),
        ((f"P114 = [{FAST}", "P114 = [99999.0"), "above its speed limit"),
        ((f"P113 = [{SLOW}, ", "P113 = ["), "P113: 6 axes need 6 numbers"),
        ((f"P113 = [{SLOW}", 'P113 = ["x"'), "P113"),
    ],
)
def test_speeds_that_do_not_fit_are_refused_by_check(change: tuple[str, str], fault: str) -> None:
    with pytest.raises(CellFaults, match=re.escape(fault)):
        load_cell("jog.toml", DEMO + SPEEDS.replace(*change))
