"""Name the case that caused an INCONC: the one that FAILed at the same step, or at the same part of the device, if any."""

import re
from collections.abc import Mapping, Sequence

from gateway.conformance.framework.base import Tester
from gateway.conformance.framework.result import Result
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import Verdict

PREPARING = "preamble: "
LIMIT = re.compile(r" within [\d.]+ m?s")
SAME_WORDS = 0.6  # in common: the same step at another place, such as the same function of another address
WORD = re.compile(r"[0-9A-Za-z:]{2,}")


def name_causes(results: Mapping[str, Result], order: Sequence[Purpose[Tester]]) -> None:
    """After the run, when all FAILs are known: the named cause does not depend on the order of the cases."""
    failed = [results[purpose.id] for purpose in order if results[purpose.id].verdict is Verdict.FAIL]
    for result in results.values():
        if result.open_cause and result.verdict is Verdict.INCONC:
            result.caused_by = _nearest(result, failed)
    for result in results.values():
        result.caused_by = _root(result.caused_by, results)


def _nearest(result: Result, failed: Sequence[Result]) -> str:
    """The same step, the same observation, the most words in common within the same part; the first of equals."""
    if not failed:
        return ""
    best = max(failed, key=lambda other: _likeness(result, other))
    return best.purpose.id if _likeness(result, best) > (0, 0.0) else ""


def _likeness(result: Result, other: Result) -> tuple[int, float]:
    reason = result.reason.removeprefix(PREPARING)
    if reason == other.reason:
        return 3, 0.0
    if result.got == other.got and _plain(result.expected) == _plain(other.expected):
        return 2, _common(reason, other.reason)
    parts = {_part(result.purpose.id), *(_part(before) for before in result.purpose.preamble)}
    common = _common(reason, other.reason)
    return (1, common) if _part(other.purpose.id) in parts or common > SAME_WORDS else (0, 0.0)


def _root(cause: str, results: Mapping[str, Result]) -> str:
    """The case at the begin of a chain of INCONC."""
    met: set[str] = set()
    while cause in results and results[cause].verdict is Verdict.INCONC and results[cause].caused_by and cause not in met:
        met.add(cause)
        cause = results[cause].caused_by
    return cause


def _part(name: str) -> str:
    """3964R_SND of 3964R_SND_BV_01."""
    return name.rsplit("_", 2)[0]


def _plain(expected: str) -> str:
    return LIMIT.sub("", expected)


def _common(one: str, other: str) -> float:
    first, second = set(WORD.findall(one)), set(WORD.findall(other))
    return len(first & second) / max(len(first | second), 1)
