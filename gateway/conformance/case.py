"""A case of the probe, and the building of the list."""

from collections.abc import Callable
from dataclasses import dataclass

from gateway.conformance.serial.bench import Bench

Run = Callable[[Bench], None]


@dataclass(frozen=True, slots=True)
class Case:
    """One test: short name, group, question, and the function that ends silently (PASS) or by a Verdict."""

    name: str
    group: str
    title: str
    run: Run


class Cases:
    """Collects cases in the order in which they are in the source."""

    def __init__(self, group: str) -> None:
        self.group, self.all = group, list[Case]()

    def case(self, name: str, title: str) -> Callable[[Run], Run]:
        """Decorator: this function is a case."""

        def keep(run: Run) -> Run:
            self.all.append(Case(f"{self.group}.{name}", self.group, title, run))
            return run

        return keep

    def add(self, name: str, title: str, run: Run) -> None:
        """One of a row of cases that differ in a value."""
        self.all.append(Case(f"{self.group}.{name}", self.group, title, run))
