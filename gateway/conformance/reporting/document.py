"""The report as one JSON object, format 1: output of `--json`, and source of pages, JUnit and `compare`."""

import datetime
import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import cast

from gateway.conformance.framework.bench_file import Bench
from gateway.conformance.framework.result import Result
from gateway.conformance.suites.registry import Suite
from gateway.pure.conformance.interval import Measure
from gateway.pure.conformance.purpose import GROUPS
from gateway.pure.conformance.verdict import Verdict, exit_code, worst

Json = dict[str, object]
KIND, FORMAT = "axisgate conformance", 1


@dataclass(frozen=True, slots=True)
class Circumstances:
    """Circumstances of a run: assumptions about the device, the tester's self-check, the order, whether the run was interrupted."""

    assumed: Sequence[str]
    self_check: Mapping[str, object]
    seed: int | None
    interrupted: bool = False


def document(
    suite: Suite, bench: Bench, pics: Mapping[str, object], results: Sequence[Result], ran: Circumstances, score: tuple[int, int]
) -> Json:
    """Everything, with the check sum over all of it but itself."""
    found: Json = {
        "kind": KIND,
        "format": FORMAT,
        "suite": {"name": suite.name, "version": suite.version, "killed": score[0], "mutants": score[1]},
        "at": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "bench": _bench(bench),
        "pics": {"stated": dict(pics), "assumed": list(ran.assumed)},
        "seed": ran.seed,
        "versions": {
            "axisgate": version("axisgate"),
            "suite": suite.version,
            "python": platform.python_version(),
            "system": f"{platform.system()} {platform.machine()}",
        },
        "self_check": dict(ran.self_check),
        "interrupted": ran.interrupted,
        "counts": counts(results),
        "cases": [case(result) for result in results],
        "coverage": coverage(results),
    }
    found["sha256"] = checksum(found)
    return found


def checksum(found: Mapping[str, object]) -> str:
    """SHA-256 over the document without its own check sum, keys in order, no spaces."""
    rest = {key: value for key, value in found.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True, default=str).encode()).hexdigest()


def _bench(bench: Bench) -> Json:
    known = {key: value.hex().upper() if isinstance(value, bytes) else value for key, value in bench.known.items()}
    return {
        "file": str(bench.path) if bench.path else None,
        "device": plain(bench.device),
        "port": {"url": bench.url, "format": bench.format} | ({} if bench.marks is None else {"marks": bench.marks}),
        "link": plain(bench.link),
        "touch": {key: list(values) for key, values in bench.touch.items()},
        "known": known,
        "stimulus": plain(bench.stimulus),
        "power": plain(bench.power),
        "report": plain(bench.report),
    }


def plain(value: object) -> object:
    """Convert to JSON types; dates of a TOML file as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value if isinstance(value, (str, int, float, bool)) or value is None else str(value)


def counts(results: Sequence[Result]) -> Json:
    """Verdict -> number of cases; waived ones separately."""
    found: Json = {verdict.value: sum(result.verdict is verdict for result in results) for verdict in Verdict}
    found["waived"] = sum(result.waived is not None and result.verdict not in (Verdict.PASS, Verdict.NA) for result in results)
    return found


def case(result: Result) -> Json:
    purpose, waived = result.purpose, result.waived
    return {
        "id": purpose.id,
        "group": purpose.group,
        "group_words": GROUPS[purpose.group],
        "role": purpose.role,
        "summary": purpose.summary,
        "summary_de": purpose.summary_de,
        "clause": purpose.clause,
        "cross_reference": purpose.cross_reference,
        "requirements": list(purpose.requirements),
        "verdict": result.verdict.value,
        "reason": result.reason,
        "expected": result.expected,
        "got": result.got,
        "measures": [_measure(one) for one in result.notes.measures],
        "host_late_ms": round(result.late / 1e6, 3),
        "caused_by": result.caused_by or None,
        "waived": None if waived is None else {"reason": waived.reason, "who": waived.who, "until": waived.until},
        "remarks": list(result.notes.remarks),
        "unasked": result.notes.unasked,
        "trace": trace(result),
        "took_ms": round(result.took / 1e6, 3),
    }


def _measure(one: Measure) -> Json:
    return {
        "what": one.what,
        "ms": round(one.ns / 1e6, 3),
        "min_ms": None if one.least is None else round(one.least / 1e6, 3),
        "max_ms": None if one.most is None else round(one.most / 1e6, 3),
        "uncertainty_ms": round(one.uncertainty / 1e6, 3),
        "clock": one.clock,
    }


def trace(result: Result) -> str:
    """The traffic on the line in order of time: > the tester, < the device."""
    parts, last = [], ""
    for piece in result.notes.trace:
        if piece.side != last:
            parts.append(">" if piece.side == "tester" else "<")
            last = piece.side
        parts.append(piece.shown())
    return " ".join(parts)


def coverage(results: Sequence[Result]) -> Json:
    """Requirement -> its cases, and the worst verdict."""
    found: dict[str, list[Result]] = {}
    for result in results:
        for requirement in result.purpose.requirements:
            found.setdefault(requirement, []).append(result)
    return {
        requirement: {"cases": [one.purpose.id for one in of], "verdict": worst(one.verdict for one in of).value}
        for requirement, of in sorted(found.items())
    }


def code_of(results: Sequence[Result]) -> int:
    """Exit code: waived cases do not count, nor those INCONC because of one."""
    waived = {result.purpose.id for result in results if result.waived is not None}
    follows = {result.purpose.id for result in results if result.verdict is Verdict.INCONC and result.caused_by in waived}
    counted = (result for result in results if result.purpose.id not in waived | follows)
    return exit_code(result.verdict for result in counted)


def cases_of(found: Mapping[str, object]) -> list[Json]:
    """The cases of a document."""
    return cast(list[Json], found["cases"])
