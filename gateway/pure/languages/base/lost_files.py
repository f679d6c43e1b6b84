"""Which files of a program could not be written: known when the program is over and all it has written was tried."""

from collections.abc import Iterable


class LostFiles:
    """Call `begins` and `over` for each run that was ordered, `written` after each turn."""

    def __init__(self) -> None:
        self._lost: dict[int, list[str]] = {}  # run -> sentences about files that were lost since it began
        self._over: list[int] = []

    def begins(self, run: int) -> None:
        """A run was ordered."""
        self._lost[run] = []

    def over(self, run: int) -> None:
        """Note the end of a run whose last writes are not on the disk yet.  Runs started by programs are not followed."""
        if run in self._lost:
            self._over.append(run)

    def written(self, faults: Iterable[str]) -> list[tuple[int, list[str]]]:
        """All is written but for these; the runs that are over, with what was lost."""
        for fault in faults:
            for lost in self._lost.values():
                if fault not in lost:
                    lost.append(fault)
        over, self._over = self._over, []
        return [(run, self._lost.pop(run)) for run in over]
