"""A virtual run: an application in virtual time, and its result as plain data."""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.tasks import SYSTEM_CYCLE
from gateway.pure.languages.val3.values import (
    AioV,
    ConfigV,
    Container,
    DioV,
    Grid,
    LinkV,
    ScreenV,
    SioV,
    Structure,
    UserV,
)
from gateway.pure.languages.val3.virtual_events import Event, check_events, happen


@dataclass(slots=True)
class Run:
    """One virtual run."""

    machine: Machine
    own: Instance
    until: Ns
    events: list[Event]

    def go(self) -> None:
        """To the end of the application, to `until`, or until nothing can happen any more."""
        self.begin()
        while self.once(self.until):
            pass

    def begin(self) -> None:
        """What is there before the start, then start()."""
        self.events.sort(key=lambda event: event.at)
        check_events(self.machine, self.own, self.events)
        self.machine.operator = any(event.what == "answer" for event in self.events)
        self.machine.keyed = any(event.what == "key" for event in self.events)
        self._happen(0)
        self.machine.start(self.own)

    def once(self, most: Ns) -> bool:
        """Some time, up to the next event; False: nothing can happen any more."""
        machine, waiting = self.machine, self.events
        if machine.ended or machine.clock >= self.until:
            return False
        moment = min([self.until, machine.clock + most, *(event.at for event in waiting[:1])])
        while machine.clock < moment and not machine.ended and not machine.halted and (waiting or not machine.stuck):
            machine.run(min(moment, machine.clock + SYSTEM_CYCLE))
        if machine.halted:
            return True
        self._happen(machine.clock)
        return bool(waiting) or machine.ended or not (machine.stuck or moment == self.until)

    def _happen(self, until: Ns) -> None:
        while self.events and self.events[0].at <= until:
            happen(self.machine, self.own, self.events.pop(0))

    def result(self) -> dict[str, object]:
        """As `axisgate val3 run --json` prints it."""
        machine = self.machine
        return {
            "globals": {name: shown_container(machine, each) for name, each in self.own.data.items()},
            "tasks": {self._name(task): {"status": task.status, "program": task.program, "line": task.line} for task in machine.tasks},
            "log": machine.log,
            "popups": machine.popups,
            "moves": machine.moves_or_none.list if machine.moves_or_none is not None else [],
            "end_s": round(min(machine.clock, self.until) / 1e9, 6),
        }

    def _name(self, task: object) -> str:
        owner, name = getattr(task, "owner", None), str(getattr(task, "name", ""))
        prefix = owner.prefix if isinstance(owner, Instance) else ""
        return f"{prefix}:{name}" if prefix else name


def shown_container(machine: Machine, container: Container) -> object:
    """An array of one value is the value (L957); arrays are lists, collections objects."""
    if isinstance(container, dict):
        return {key: shown(machine, value) for key, value in sorted(container.items())}
    if isinstance(container, Grid):
        return _rows(machine, container.dims, container.flat)
    return shown(machine, container[0]) if len(container) == 1 else [shown(machine, value) for value in container]


def _rows(machine: Machine, dims: tuple[int, ...], flat: list[object]) -> list[object]:
    if len(dims) == 1:
        return [shown(machine, value) for value in flat]
    size = len(flat) // dims[0]
    return [_rows(machine, dims[1:], flat[at * size : (at + 1) * size]) for at in range(dims[0])]


def shown(machine: Machine, value: object) -> object:
    """Return one value: numbers without a fraction as integers, structures by field."""
    match value:
        case float():
            if not math.isfinite(value):
                return str(value)  # JSON has no number for it
            return int(value) if value.is_integer() and abs(value) < 1e15 else value
        case DioV():
            point = machine.io.find(value.link) if value.link else None
            return None if point is None else point.value != 0
        case AioV():
            point = machine.io.find(value.link) if value.link else None
            return None if point is None else shown(machine, point.value)
        case LinkV():
            return value.link
        case ScreenV():
            return machine.screen.lines
        case UserV():
            return {name: shown_container(machine, getattr(value, f"u_{name}")) for name in value.type.fields}
        case ConfigV() if machine.family == "rs":
            return {"shoulder": value.shoulder}
        case Structure():
            return {name: shown(machine, getattr(value, name)) for name in value.names() if name != "father"}
    return value


def declare_links(machine: Machine, containers: Collection[Container]) -> None:
    """Links with a path first, so that bare names find them."""
    links = [link for container in containers for value in values_of(container) for link in links_of(value)]
    for link in sorted(set(links), key=lambda each: ("\\" not in each, each)):
        machine.io.declare(link)
    for variable in (value for container in containers for value in values_of(container) if isinstance(value, SioV)):
        if variable.link:
            machine.sio.declare(variable.link)


def values_of(container: Container) -> Iterable[object]:
    """All values of a container."""
    return container.values() if isinstance(container, dict) else container.flat if isinstance(container, Grid) else container


def links_of(value: object) -> Iterable[str]:
    """Links to inputs and outputs in a value."""
    if isinstance(value, DioV | AioV):
        return [value.link] if value.link else []
    if isinstance(value, UserV):
        return [link for name in value.names() for one in values_of(getattr(value, name)) for link in links_of(one)]
    gripper = getattr(value, "gripper", None)
    return [gripper.link] if isinstance(gripper, DioV) and gripper.link else []


def summary(result: Mapping[str, object]) -> list[str]:
    """The result for a person."""
    tasks, log, popups = result["tasks"], result["log"], result["popups"]
    lines = [f"ended after {result['end_s']} s of virtual time"]
    if isinstance(tasks, dict):
        lines += [f"task {name}: status {each['status']}, {each['program']} line {each['line']}" for name, each in tasks.items()]
    lines += [f"popup: {text}" for text in popups] if isinstance(popups, list) else []
    return lines + ([str(line) for line in log] if isinstance(log, list) else [])
