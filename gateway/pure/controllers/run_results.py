"""How the last runs of programs ended, and which files that they wrote are not on the disk."""

from collections.abc import Iterable, Mapping

from gateway.pure.image.records.interpreter import Fact

Outcome = tuple[str, int, str, str]  # how, code, text, place
MOST = 64
GONE = "lost"  # how a run ends whose interpreter does


class RunResults(dict[int, Outcome]):
    """By number of the run."""

    def __init__(self) -> None:
        super().__init__()
        self._lost: dict[int, list[str]] = {}  # sentences about files that could not be written, of runs whose files were tried

    def end(self, run: int, outcome: Outcome) -> None:
        """A run is over."""
        self[run] = outcome
        for old in list(self)[:-MOST]:
            del self[old]

    def kept(self, said: Mapping[str, Fact]) -> None:
        """The interpreter has tried all files of a run."""
        self._lost[int(said["run"])] = str(said["text"]).splitlines()
        for old in list(self._lost)[:-MOST]:
            del self._lost[old]

    def answer(self, run: object, rows: Iterable[dict[str, object]], *, alive: bool) -> dict[str, object]:
        """To a tool: how a run is, or how it ended.  `alive`: the interpreter runs; it may still report files."""
        if not isinstance(run, int):
            return {"error": "state: run = a number that start returned"}
        if (over := self.get(run)) is None:
            return {"over": False, "rows": [row for row in rows if row["run"] == run]}
        how, code, words, place = over
        kept = run in self._lost or how == GONE or not alive
        return {"over": True, "how": how, "code": code, "text": words, "place": place, "kept": kept, "lost": self._lost.get(run, [])}
