"""The test system of the old controller on the page: start in test, breakpoints, steps, variables, points (AX-1040)."""

import asyncio
import time
from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field

from gateway.observer.tool_link import Refused
from gateway.web.bodies import Body, ProgramName
from gateway.web.endpoints import Call, Endpoint
from gateway.web.operator_control import OperatorControl
from gateway.web.store import Role

Row = dict[str, Any]
OUTCOME_S = 3.0  # the interpreter answers within a turn
AGAIN_S = 0.03
Run = Annotated[int, Field(ge=1, le=2**31)]
PointName = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^@?[^\W\d]\w*$")]


class TestStart(ProgramName):
    """A program to be tested; hold: before its first line."""

    __test__ = False
    hold: bool = False


class Breakpoints(ProgramName):
    """All breakpoints of a program."""

    lines: Annotated[list[Annotated[int, Field(ge=1, le=32767)]], Field(max_length=100)]


class TestStep(Body):
    """How a held process continues."""

    __test__ = False
    run: Run
    how: Literal["run", "into", "over", "out", "hold"]


class SingleStep(Body):
    """One step of a program of a Reis; name "": of the one that is selected."""

    name: Annotated[str, Field(max_length=128, pattern=r"^[^\x00-\x1f]*$")] = ""
    how: Literal["into", "over", "out"]


class Movement(Body):
    """WITH or WITHOUT movement, for all kinematics."""

    on: bool


class Variable(Body):
    """A variable of a process that is held."""

    run: Run
    program: Annotated[str, Field(min_length=1, max_length=32)]
    name: Annotated[str, Field(min_length=1, max_length=64)]
    value: Annotated[str, Field(max_length=200)]


class Teach(ProgramName):
    """A point of a program is set to the actual position; kinematic 0: that of the program."""

    point: PointName
    kinematic: Annotated[int, Field(ge=0, le=16)] = 0


class Define(ProgramName):
    """A point of a program by its numbers."""

    point: PointName
    value: Annotated[str, Field(min_length=1, max_length=200)]


class ProgramTests:
    """Orders of one page to the interpreter; each waits for its result."""

    def __init__(self, operator_control: Callable[[], OperatorControl]) -> None:
        self._look_up = operator_control

    @property
    def _operator_control(self) -> OperatorControl:
        return self._look_up()

    async def _order(self, call: Call, what: str, **facts: object) -> Row:
        self._operator_control.free(call.person.key)
        answer = await self._operator_control.services_link.ask("process", do=what, **facts)
        until = time.monotonic() + OUTCOME_S
        while time.monotonic() < until:
            outcome = await self._operator_control.services_link.ask("process", do="outcome", ticket=answer["ticket"])
            if outcome["over"]:
                return {"ok": True}
            await asyncio.sleep(AGAIN_S)
        raise Refused("the interpreter does not answer")

    async def start(self, call: Call) -> Row:
        body: TestStart = call.body
        return await self._operator_control.start_program(call.person.key, body.name, do="test", hold=body.hold)

    async def breakpoints(self, call: Call) -> Row:
        body: Breakpoints = call.body
        return await self._order(call, "breakpoints", name=body.name, lines=body.lines)

    async def step(self, call: Call) -> Row:
        body: TestStep = call.body
        return await self._order(call, "step", run=body.run, how=body.how)

    async def single(self, call: Call) -> Row:
        body: SingleStep = call.body
        return await self._operator_control.start_program(call.person.key, body.name, do="step", how=body.how)

    async def movement(self, call: Call) -> Row:
        body: Movement = call.body
        return await self._order(call, "movement", on=body.on)

    async def variable(self, call: Call) -> Row:
        body: Variable = call.body
        return await self._order(call, "variable", run=body.run, program=body.program, name=body.name, value=body.value)

    async def teach(self, call: Call) -> Row:
        body: Teach = call.body
        return await self._order(call, "teach", name=body.name, point=body.point, kinematic=body.kinematic)

    async def define(self, call: Call) -> Row:
        body: Define = call.body
        return await self._order(call, "define", name=body.name, point=body.point, value=body.value)

    async def value(self, call: Call) -> Row:
        """A variable by its name, among those shown on the page Programs."""
        name = call.query.get("name", "")
        if not name or len(name) > 64:
            raise ValueError("name: that of a variable, at most 64 characters")
        await self._operator_control.services_link.ask("process", do="value", name=name)
        return {"ok": True}

    async def look(self, call: Call) -> Row:
        """Show its variables on the page Programs for some seconds."""
        run = call.query.get("run", "")
        if not run.isascii() or not run.isdigit() or len(run) > 10:
            raise ValueError("run: the number of a process")
        await self._operator_control.services_link.ask("process", do="look", run=int(run))
        return {"ok": True}


def program_test_endpoints(tests: ProgramTests) -> list[Endpoint]:
    """Endpoints of the test system."""
    v, o, s = Role.VIEWER, Role.OPERATOR, Role.SETTER
    row = Endpoint
    return [
        row("GET", "/api/program/look", v, "show the variables of a process on the page Programs", tests.look, query=(("run", "string"),)),
        row("GET", "/api/program/value", v, "show a variable of a Reis on the page Programs", tests.value, query=(("name", "string"),)),
        row("POST", "/api/program/test", o, "start a program in test", tests.start, TestStart, True),
        row("POST", "/api/program/breakpoints", o, "set all breakpoints of a program", tests.breakpoints, Breakpoints, True),
        row("POST", "/api/program/step", o, "step, continue or hold a process of the test", tests.step, TestStep, True),
        row("POST", "/api/program/single", o, "execute one step of a program of a Reis", tests.single, SingleStep, True),
        row("POST", "/api/program/movement", s, "test with or without movement", tests.movement, Movement, True),
        row("POST", "/api/program/variable", s, "set a variable of a process that is held", tests.variable, Variable, True),
        row("POST", "/api/program/teach", s, "store the actual position as a point", tests.teach, Teach, True),
        row("POST", "/api/program/define", s, "store a point by its numbers", tests.define, Define, True),
    ]
