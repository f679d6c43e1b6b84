"""Single steps of a Reis program from the page: endpoint, operator control, control, interpreter and axes in virtual time."""

import asyncio
from typing import cast

import pytest
from starlette.requests import Request

from gateway.observer.regions import Regions
from gateway.observer.tool_link import Refused, ServicesLink
from gateway.web.access import Person
from gateway.web.audit_words import sentences_of
from gateway.web.endpoints import Call
from gateway.web.german import german
from gateway.web.operator_control import NotYours, OperatorControl
from gateway.web.program_test import ProgramTests, Row, program_test_endpoints
from gateway.web.store import Role
from hil_tests.lab.virtual.reis_bench import ReisCell, at, main

PATH = "/api/program/single"
BODY = f"MOVE_MODE #LINEAR\nPATH_SPEED 300\n{at(884, 0, 591)}\nCOPY 7, I1\nSTOP"


class Page:
    """A page in front of a cell in a test mode."""

    def __init__(self) -> None:
        self.cell = ReisCell(main(BODY) | {"V.MPR": 'MPR "V"\nVAR I1\nEND\n'})
        self.operator_control = OperatorControl(cast(ServicesLink, self), cast(Regions, None), self.cell.cell.axis)
        rows = program_test_endpoints(ProgramTests(lambda: self.operator_control))
        self.endpoint = next(row for row in rows if row.path == PATH)

    async def ask(self, op: str, **request: object) -> dict[str, object]:
        """The way to the services: without control on the page the program moves as the PLC; Refused."""
        assert op == "process"
        answer = self.cell.hosted.answer(request, 0)
        if "error" in answer:
            raise Refused(str(answer["error"]))
        return answer

    def steps(self, **body: object) -> tuple[str, int]:
        """One step; where the program is behind it."""
        assert self.endpoint.body is not None
        person = Person("me", Role.OPERATOR, "127.0.0.1", True, "key")
        call = Call(person, self.endpoint.body.model_validate(body), {}, {}, cast(Request, None))

        async def handled() -> Row:
            answer = await self.endpoint.handler(call)
            assert isinstance(answer, dict)
            return answer

        answer = asyncio.run(handled())
        self.cell.ends(int(answer["run"]))
        row = self.cell.language.rows()[0]
        return row.program, row.line


def test_each_press_executes_one_step_in_test() -> None:
    page = Page()
    with pytest.raises(Refused) as auto:
        page.steps(name="P", how="into")
    assert german(str(auto.value)) == "P: Einzelschritte gibt es in Test 1 bis 6, nicht in AUTO"
    page.cell.bench.permit(23, value=False)
    page.cell.control.put("reis.mode", 2.0)
    page.cell.bench.run(0.1)
    assert page.steps(name="P", how="into") == ("P", 2)
    assert [page.steps(how=how)[1] for how in ("into", "over", "into")] == [3, 4, 5]
    before = page.cell.where()
    assert page.steps(how="into") == ("P", 6) and page.cell.where() == pytest.approx((884, 0, 591), abs=0.05) != before
    assert page.cell.value("I1") is None
    assert page.steps(how="into") == ("P", 7) and page.cell.value("I1") == "7"
    assert page.steps(how="out") == ("P", 7), "not called by a program"


def test_another_users_control_and_wrong_orders_are_refused() -> None:
    page = Page()
    page.operator_control.holder, page.operator_control.name = "another", "Eve"
    with pytest.raises(NotYours, match="Eve"):
        page.steps(name="P", how="into")
    with pytest.raises(ValueError, match="how"):
        page.steps(name="P", how="run")
    assert page.endpoint.changes and page.endpoint.role is Role.OPERATOR
    assert sentences_of(f"POST {PATH}", '{"name": "P", "how": "into"}', ())[1] == "Einzelschritt von Programm P: into"
