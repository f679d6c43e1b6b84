"""One case of a run, as the report shows it."""

from dataclasses import dataclass, field

from gateway.conformance.framework.base import Notes, Tester
from gateway.conformance.framework.bench_file import Waiver
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Ns


@dataclass(slots=True)
class Result:
    """One case of the report."""

    purpose: Purpose[Tester]
    verdict: Verdict
    reason: str = ""
    expected: str = ""
    got: str = ""
    caused_by: str = ""
    open_cause: bool = False  # a preparing step failed: which case judges it is known after the run
    uncertain: bool = False  # a time overlaps its limit, all else was right: cases that depend on this one can run
    notes: Notes = field(default_factory=Notes)
    late: Ns = 0
    took: Ns = 0
    waived: Waiver | None = None
    behind: str = ""  # a FAIL that was seen while this host was late
