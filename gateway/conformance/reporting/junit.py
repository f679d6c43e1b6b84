"""The report as JUnit XML, for a build server."""

from collections.abc import Mapping
from typing import cast
from xml.etree import ElementTree

from gateway.conformance.reporting.document import Json, cases_of

FORBIDDEN = dict.fromkeys((*range(9), 11, 12, *range(14, 32)), " ")


def to_junit(found: Mapping[str, object]) -> str:
    """FAIL: failure; ERROR and INCONC: error; N/A and waived: skipped."""
    suite, cases = cast(Json, found["suite"]), cases_of(found)
    root = ElementTree.Element("testsuites")
    top = ElementTree.SubElement(root, "testsuite", name=str(suite["name"]), timestamp=str(found["at"]))
    totals = {"tests": len(cases), "failures": 0, "errors": 0, "skipped": 0}
    for case in cases:
        seconds = f"{float(cast(float, case['took_ms'])) / 1000:.3f}"
        node = ElementTree.SubElement(top, "testcase", classname=f"{suite['name']}.{case['group']}", name=str(case["id"]), time=seconds)
        kind = _kind(case)
        if kind is not None:
            totals[f"{kind}s" if kind != "skipped" else kind] += 1
            entry = ElementTree.SubElement(node, kind, message=_text(case["reason"]) or str(case["verdict"]))
            if kind != "skipped":
                entry.text = _text(f"expected: {case['expected']}\ngot: {case['got']}\n{case['trace']}")
    for name, count in totals.items():
        top.set(name, str(count))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _kind(case: Mapping[str, object]) -> str | None:
    if case["verdict"] in ("PASS", "WARN"):
        return None
    if case["verdict"] == "N/A" or case["waived"]:
        return "skipped"
    return "failure" if case["verdict"] == "FAIL" else "error"


def _text(value: object) -> str:
    return str(value).translate(FORBIDDEN)
