"""Verdicts of conformance cases, and how a case ends with one."""

from collections.abc import Iterable
from enum import Enum


class Verdict(Enum):
    """In the order of weight: the worst one wins."""

    NA = "N/A"
    PASS = "PASS"
    WARN = "WARN"  # disputed text, interoperability
    INCONC = "INCONC"
    FAIL = "FAIL"
    ERROR = "ERROR"  # of the tester itself


WEIGHT = {verdict: weight for weight, verdict in enumerate(Verdict)}


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Of several; PASS of none."""
    return max(verdicts, key=WEIGHT.__getitem__, default=Verdict.PASS)


def exit_code(verdicts: Iterable[Verdict]) -> int:
    """0: only PASS, WARN, N/A (and waived, which the caller leaves out); 1: a FAIL; 3: ERROR, or INCONC without FAIL."""
    found = set(verdicts)
    if Verdict.FAIL in found:
        return 1
    return 3 if found & {Verdict.ERROR, Verdict.INCONC} else 0


class Ended(Exception):
    """Ends a case before its last line.  `expected` and `got` are in hex and words."""

    verdict = Verdict.PASS

    def __init__(self, reason: str, expected: str = "", got: str = "", caused_by: str = "") -> None:
        super().__init__(reason)
        self.reason, self.expected, self.got, self.caused_by = reason, expected, got, caused_by


class Fail(Ended):
    verdict = Verdict.FAIL


class Warn(Ended):
    verdict = Verdict.WARN


class Inconclusive(Ended):
    verdict = Verdict.INCONC


class NotApplicable(Ended):
    verdict = Verdict.NA


class Disturbed(Inconclusive):
    """The device sent something unasked at a moment that matters: the case is repeated."""


class Uncertain(Disturbed):
    """A time lies across its limit: this host may be the cause as well as the device."""


class BenchFault(Inconclusive):
    """A command, a relay or the operator of the bench failed, not the device under test."""
