"""Instructions on tasks, time and the watchdog.  Source: VAL 3 reference 5.10-5.11, L3548-3853."""

import math
from collections.abc import Callable, Generator

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance, Program
from gateway.pure.languages.val3.tasks import RUNNING, SUSPENDED, SYSTEM_CYCLE, Task
from gateway.pure.languages.val3.values import LONGEST, cut

Waiting = Generator[Ns | None, None, object]
LONGEST_NAME = 15  # up to s7; applications of s8 have longer ones
MOST_TASKS = 200


def _named(own: Instance, name: str) -> None:
    longest = LONGEST if own.loaded.app.since_s8 else LONGEST_NAME
    if not 1 <= len(name) <= longest or not all(each.isascii() and (each.isalnum() or each == "_") for each in name):
        raise Rte(29, repr(name))
    if own.machine.task(own, name) is not None:
        raise Rte(31, name)
    if len(own.machine.tasks) >= MOST_TASKS:
        raise Rte(40, f"{MOST_TASKS} tasks")


def f_task_create(own: Instance, name: str, priority: float, program: Program, arguments: list[object]) -> None:
    """29, 31, 40, 70."""
    _named(own, name)
    lines = math.floor(priority + 0.5)
    if not 1 <= lines <= 100:
        raise Rte(70, f"priority {priority:g}, 1 to 100")
    task = Task(name, own, lines)
    task.enter(program, arguments)
    own.machine.add(task)


def f_task_create_sync(
    own: Instance, name: str, period: float, overrun: tuple[object, object], program: Program, arguments: list[object]
) -> None:
    """The period is rounded down to the system cycle; 32 for a third one (L3755)."""
    _named(own, name)
    if not period > 0:
        raise Rte(70, f"period {period:g} s")
    cycles = max(math.floor(period * 1e9 / SYSTEM_CYCLE + 1e-6), 1)
    others = {task.period for task in own.machine.tasks if task.period}
    if len(others | {cycles * SYSTEM_CYCLE}) > 2:
        raise Rte(32, f"{period:g} s")
    task = Task(name, own, 0, period=cycles * SYSTEM_CYCLE, overrun=overrun)
    task.enter(program, arguments)
    own.machine.add(task)


def _known(own: Instance, name: str) -> Task:
    task = own.machine.task(own, name)
    if task is None:
        raise Rte(30, name)
    return task


def f_task_suspend(own: Instance, name: str) -> Waiting:
    """No effect on a stopped task; 30."""
    task = _known(own, name)
    if task.status == RUNNING:
        task.status = SUSPENDED
        if task is own.machine.current:
            yield None
    return None


def f_task_resume(own: Instance, name: str, skip: float) -> Waiting:
    """Only of a stopped task; 30, 90."""
    task = _known(own, name)
    if task.status != RUNNING:
        task.resume_at(math.floor(skip + 0.5))
        own.machine.restarted(task)
    if not own.machine.current_is_synchronous:
        yield own.machine.now
    return None


def f_task_kill(own: Instance, name: str) -> Waiting:
    """No effect where there is none."""
    task = own.machine.task(own, name)
    if task is not None:
        own.machine.kill(task)
        if task is own.machine.current:
            yield None
    if not own.machine.current_is_synchronous:
        yield own.machine.now
    return None


def f_task_status(own: Instance, name: str) -> float:
    """-1, 0, 1 or the code of its error."""
    task = own.machine.task(own, name)
    return -1.0 if task is None else float(task.status)


def f_help(own: Instance, code: float) -> str:
    """The description of a code."""
    return cut(own.machine.help(int(code))) if code == int(code) else ""


def f_set_mutex(own: Instance, mutex: tuple[list[object], int]) -> Waiting:
    """Waits until it is false, then sets it."""
    if not own.machine.current_is_synchronous:
        yield own.machine.now
    while mutex[0][mutex[1]]:
        yield None
    mutex[0][mutex[1]] = True
    return None


def f_wait(own: Instance, condition: Callable[[], bool]) -> Waiting:
    """True at once: no yield."""
    while not condition():
        yield None
    return None


def f_watch(own: Instance, condition: Callable[[], bool], seconds: float) -> Waiting:
    """Whether it came true in time; yields once where it is not true at once."""
    end = own.machine.now + max(round(seconds * 1e9), 0)
    first = True
    while not condition():
        if not first and own.machine.now >= end:
            return False
        own.machine.expect(end)
        first = False
        yield None
    return True


def f_wait_for(own: Instance, condition: Callable[[], Waiting]) -> Waiting:
    """wait with an instruction in its condition that may wait itself, as sioGet."""
    while not (yield from condition()):
        yield None
    return None


def f_watch_for(own: Instance, condition: Callable[[], Waiting], seconds: float) -> Waiting:
    """watch with an instruction in its condition that may wait itself: the time is looked at when that has ended (AX-1760)."""
    end = own.machine.now + max(round(seconds * 1e9), 0)
    first = True
    while not (yield from condition()):
        if not first and own.machine.now >= end:
            return False
        own.machine.expect(end)
        first = False
        yield None
    return True


def f_delay(own: Instance, seconds: float) -> Waiting:
    """Always yields."""
    end = own.machine.now + max(round(seconds * 1e9), 0)
    yield end
    while own.machine.now < end:
        yield end
    return None


def f_clock(own: Instance) -> float:
    """Seconds since the start, in steps of 1 ms."""
    return own.machine.now // 1_000_000 / 1000


def f_wdg_refresh(own: Instance) -> bool:
    """false: this call started it; 45 without a watchdog."""
    return own.machine.robot.refresh_watchdog(own.machine.now)
