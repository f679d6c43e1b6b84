"""Statements that use an accumulator that an earlier, untranslated statement would have filled."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from gateway.pure.languages.plc.awl.reader import Statement
from gateway.pure.languages.plc.awl.translator import CALCULATES, COMPARES, SHIFTS

ALONE = {*SHIFTS, *(word for word, to in CALCULATES.items() if to in ("K E", "K Z", "DH", "HD")), "I", "D", "INC", "DEC", "+", "ADD"}
BOTH = {*COMPARES, *CALCULATES, "MOD"} - ALONE - {"TAK"}
STARTS = ("SI", "SV", "SE", "SA")  # of a timer, with the time in the accumulator
LOADS = ("L", "LC", "LIR")
FILLS = ("ITD", "DTR", "RND", "RND+", "RND-", "TRUNC", "+R", "-R", "*R", "/R", "SVW", "SVD", "SSI", "SSD", "PUSH", "POP", "ENT", "LEAVE")


@dataclass(slots=True)
class Accumulators:
    """The line that should have filled each accumulator and was not translated; 0: it holds what the list means."""

    one: int = 0
    two: int = 0

    def after(self, statement: Statement, refused: bool) -> int:
        """Takes a statement; the missing line that it uses, 0: none."""
        word, line = statement.word, statement.line if refused else 0
        if statement.label:  # a jump to here has loaded something else
            self.one = self.two = 0
        if word in LOADS:
            self.two, self.one = self.one, line
        elif word == "TAK":
            self.one, self.two = self.two, self.one
        elif word in BOTH:
            found = self.one or self.two
            if word not in COMPARES:
                self.one = line or found
            return found
        elif word in ALONE or word in FILLS:
            found, self.one = self.one, line or self.one
            return found
        elif word == "T" or word in STARTS:
            return self.one
        return 0


def unfed(name: str, statements: Collection[Statement], refused: Collection[int]) -> Iterator[str]:
    """Yield a note for each translated statement that uses a value that a line of `refused` would have supplied."""
    accumulators = Accumulators()
    for statement in statements:
        missing = accumulators.after(statement, statement.line in refused)
        if missing and statement.line not in refused:
            where = f"line {statement.line} ({name}): {statement.text[:60]}"
            yield f"{where}: uses what line {missing} would have loaded, which is not translated"
