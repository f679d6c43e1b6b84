"""Wait graph: semaphores, kinematics, branches; finds processes that wait for each other in a circle (AX-1731).  Pure.

A process can be waited for in two ways: until it continues in its program, and until its prepared blocks are over.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

from gateway.pure.languages.baps2.demands import Branches, Enter
from gateway.pure.languages.baps2.tasks import Release, Task
from gateway.pure.languages.base.process import ProcessState

SEMAPHORE, KINEMATIC, BRANCHES = "semaphore", "kinematic", "its branches"


@dataclass(frozen=True, slots=True)
class Wait:
    """What a process waits for: a semaphore or a kinematic by its name, or its branches.  `blocks`: until blocks of the holder are over,
    whatever its program does meanwhile."""

    what: str
    name: str
    holder: Task
    blocks: bool = False

    def __str__(self) -> str:
        if self.what == BRANCHES:
            return f"its branch in line {self.holder.process.line}"
        return f"{self.what} {self.name}, held by {place_of(self.holder)}"


class Holders(Protocol):
    """What is held."""

    def holder_of(self, semaphore: tuple[str, str]) -> Task | None:
        """The process in an EXCLUSIVE part of it."""

    def kinematic_wait(self, task: Task) -> Wait | None:
        """The kinematic that the next block of this process, or its SYNCHRON, waits for."""


Node = tuple[Task, bool]  # a process; whether of its blocks


def place_of(task: Task) -> str:
    """Program and line, in words."""
    return f"{task.unit.name} line {task.process.line}{' (branch)' if task.root is not None else ''}"


def waits_of(task: Task, tasks: Iterable[Task], held: Holders) -> Iterator[Wait]:
    """What a process waits for of others, the next thing first."""
    asked = task.process.waits_for if task.process.state is ProcessState.WAITING else None
    if isinstance(asked, Enter):
        holder = held.holder_of(asked.semaphore)
        if holder is not None and holder is not task:
            ends = any(isinstance(item, Release) and item.semaphore == asked.semaphore for item in holder.queue)
            yield Wait(SEMAPHORE, asked.semaphore[1], holder, ends)
    elif isinstance(asked, Branches):
        for each in tasks:
            if each.process.parent is task.process:
                yield Wait(BRANCHES, "", each)
    yield from _of_kinematic(task, held)


def _of_kinematic(task: Task, held: Holders) -> Iterator[Wait]:
    found = held.kinematic_wait(task)
    if found is not None:
        yield found


def circle(tasks: Iterable[Task], held: Holders) -> list[tuple[Task, Wait]]:
    """Processes each of which waits for the next, the last for the first; empty: every wait can end."""
    every = list(tasks)
    done: set[Node] = set()
    for start in every:
        way: list[tuple[Node, Wait]] = []
        found = _follow((start, False), way, done, every, held)
        if found:
            return found
    return []


def _follow(node: Node, way: list[tuple[Node, Wait]], done: set[Node], tasks: list[Task], held: Holders) -> list[tuple[Task, Wait]]:
    on_way = [each for each, _ in way]
    if node in on_way:
        return [(task, wait) for (task, _), wait in way[on_way.index(node) :]]
    if node in done:
        return []
    done.add(node)
    task, blocks = node
    for wait in _of_kinematic(task, held) if blocks else waits_of(task, tasks, held):
        way.append((node, wait))
        found = _follow((wait.holder, wait.blocks), way, done, tasks, held)
        if found:
            return found
        way.pop()
    return []


def words(found: Iterable[tuple[Task, Wait]]) -> str:
    """The circle as a sentence."""
    rows = "; ".join(f"{place_of(task)} waits for {wait}" for task, wait in found)
    return f"these processes wait for each other, and none continues until one is stopped: {rows}"


class Watch:
    """Finds each circle once."""

    def __init__(self) -> None:
        self._reported: frozenset[int] = frozenset()

    def has(self, task: Task) -> bool:
        """Whether this process is in the circle."""
        return task.process.number in self._reported

    def look(self, tasks: Iterable[Task], held: Holders) -> list[tuple[Task, Wait]]:
        """A circle that has not been reported."""
        found = circle(tasks, held)
        members = frozenset(task.process.number for task, _ in found)
        new = members != self._reported
        self._reported = members
        return found if new else []
