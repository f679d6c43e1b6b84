"""The printed report: no sheet has more than a page holds, in both languages, with many findings and long traces."""

import pathlib
import re
import subprocess
from typing import Any

import pytest

from gateway.conformance.reporting.page import to_html
from hil_tests.lab.running.web_running import CHROMIUM

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]

MOST_MM = 272.0
MEASURE = """<style>section{min-height:0!important;height:auto!important;padding:0!important;margin:0!important;
width:186mm!important}</style>
<p id=found></p><script>const heights=[...document.querySelectorAll('section')].map(s=>s.getBoundingClientRect().height/96*25.4);
document.getElementById('found').textContent='heights '+heights.map(h=>h.toFixed(1)).join(' ')+' end'</script>"""


def _case(at: int, verdict: str, reason: str, trace: str) -> dict[str, Any]:
    measure = {"what": "NAK (15h) after silence in the data", "ms": 220.5, "min_ms": 198.9, "max_ms": 241.1, "uncertainty_ms": 12.345}
    return {
        "id": f"3964R_RCV_BV_{at:02}",
        "summary": "a character delay shorter than that of the profile is none, and begins again with each character",
        "summary_de": "eine Zeichenverzugszeit kürzer als die des Profils ist keine und beginnt mit jedem Zeichen neu",
        "clause": "serial-protocols 1.4: noted, heard to the end",
        "verdict": verdict,
        "reason": reason,
        "expected": "NAK (15h)",
        "got": "nothing",
        "caused_by": None,
        "waived": None,
        "measures": [measure] * 3,
        "trace": trace,
    }


def _found(cases: list[dict[str, Any]], assumed: list[str], language: str) -> dict[str, Any]:
    device = {"maker": "Muster", "type": "CP 77", "serial_number": "0815", "firmware": "2.1", "hardware": "3", "version": "4"}
    port = {"url": "machine:/a/long/path/to/the/folder/of/the/bench/example_station.py:station?kind=x", "format": "9600 8E1"}
    return {
        "suite": {"name": "3964r", "version": "1.0", "killed": 110, "mutants": 110},
        "counts": {"FAIL": len(cases)},
        "bench": {"port": port, "device": device, "report": {"language": language, "number": "PB-2026-117"}},
        "seed": None,
        "versions": {"axisgate": "0.1.0", "suite": "1.0", "python": "3.11.7", "system": "Linux x86_64"},
        "sha256": "0" * 64,
        "interrupted": False,
        "at": "2026-11-28T20:57:32+00:00",
        "self_check": {"clock": "virtual", "echo": False},
        "pics": {"assumed": assumed, "stated": {"profile": "rho3"}},
        "coverage": {f"RHO-SER-{at:02}": {"verdict": "FAIL", "cases": [case["id"] for case in cases]} for at in range(1, 13)},
        "cases": cases,
    }


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("verdict, reason", [("PASS", ""), ("FAIL", "after a block of 139 characters: nothing, expected NAK (15h)")])
def test_no_sheet_holds_more_than_a_page(tmp_path: pathlib.Path, language: str, verdict: str, reason: str) -> None:
    trace = "" if verdict == "PASS" else "> 02 < 10 > 55 56 57 10 03 46 " * 20
    cases = [_case(at, verdict, reason, trace) for at in range(1, 41)]
    page = tmp_path / "report.html"
    page.write_text(to_html(_found(cases, ["missing block: DB99"] * 70, language), language) + MEASURE, encoding="utf-8")
    argv = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1400,900", "--dump-dom", page.as_uri()]
    told = subprocess.run(argv, capture_output=True, text=True, timeout=120, check=True).stdout
    heights = [float(one) for one in re.findall(r"heights ([\d. ]+) end", told)[-1].split()]
    assert len(heights) > 4
    assert max(heights) <= MOST_MM
