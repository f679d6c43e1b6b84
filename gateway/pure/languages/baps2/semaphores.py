"""Semaphores of programs: one process holds one, others wait for it.  Pure."""

from collections.abc import Iterable

from gateway.pure.languages.baps2.demands import Enter
from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.base.requests import PENDING


class Semaphores:
    """Which process holds which semaphore; `processes` are all that run."""

    def __init__(self) -> None:
        self._holders: dict[tuple[str, str], Task] = {}

    def enter(self, task: Task, semaphore: tuple[str, str]) -> object:
        """Takes a free one; PENDING while another process holds it."""
        holder = self._holders.get(semaphore)
        if holder is None:
            self._holders[semaphore] = task
            task.semaphores.append(semaphore)
        return None if holder in (None, task) else PENDING

    def leave(self, task: Task, semaphore: tuple[str, str], processes: Iterable[Task]) -> None:
        """Gives away one that this process holds."""
        if self._holders.get(semaphore) is task:
            self._give_away(task, semaphore, processes)

    def leave_all(self, task: Task, processes: Iterable[Task]) -> None:
        """The process is over."""
        for semaphore in list(task.semaphores):
            self._give_away(task, semaphore, processes)

    def _give_away(self, task: Task, semaphore: tuple[str, str], processes: Iterable[Task]) -> None:
        """To the first one that waits for it, by priority; else it is free.  So a loop that enters again at once lets others in."""
        task.semaphores.remove(semaphore)
        waiting = [each for each in processes if each is not task and each.process.waits_for == Enter(semaphore)]
        heir = min(waiting, key=lambda each: (each.process.priority, each.since), default=None)
        if heir is None:
            del self._holders[semaphore]
            return
        self._holders[semaphore] = heir
        heir.semaphores.append(semaphore)
