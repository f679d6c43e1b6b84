"""Semaphores of programs: one process holds one, others wait for it.  Pure."""

from collections.abc import Iterable

from gateway.pure.languages.baps2.demands import Enter
from gateway.pure.languages.baps2.tasks import Release, Task
from gateway.pure.languages.baps2.waiting import Watch
from gateway.pure.languages.base.requests import PENDING


class Semaphores:
    """Which process holds which semaphore; `processes` are all that run."""

    def __init__(self) -> None:
        self._holders: dict[tuple[str, str], Task] = {}
        self.watch = Watch()  # of processes that wait for each other

    @property
    def held(self) -> bool:
        """Whether any is."""
        return bool(self._holders)

    def holder_of(self, semaphore: tuple[str, str]) -> Task | None:
        """The process that has it."""
        return self._holders.get(semaphore)

    def enter(self, task: Task, semaphore: tuple[str, str]) -> object:
        """Takes a free one; PENDING while another process holds it, or blocks of this one run that are in its part before."""
        holder = self._holders.get(semaphore)
        if holder not in (None, task) or any(isinstance(item, Release) and item.semaphore == semaphore for item in task.queue):
            return PENDING
        if holder is None:
            self._holders[semaphore] = task
            task.semaphores.append(semaphore)
        task.entered.setdefault(semaphore, []).append(task.queue[-1] if task.queue else None)
        return None

    def end(self, task: Task, semaphore: tuple[str, str], processes: Iterable[Task]) -> None:
        """EXCLUSIVE_END of the outermost part: after the blocks that were prepared in it; at once where none is left."""
        parts = task.entered[semaphore]
        before = parts.pop()
        if parts:
            return
        if task.queue and task.queue[-1] is not before:
            task.queue.append(Release(semaphore))
        else:
            self.leave(task, semaphore, processes)

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
