"""The probe's report as JSON and as one self-contained HTML page."""

import html
import json
from collections.abc import Callable, Iterator, Mapping, Sequence

from gateway.conformance.serial.bench import Notes, named
from gateway.conformance.serial.run import Result, Settings, conclusion, counted
from gateway.pure.lines.texts import in_language, said
from protocols.base.machine import Damage

TEXT = (
    "This report states how the tested item behaved in the listed tests on the listed bench. It is not a certificate and not a "
    "conformity test of CAN in Automation, the Modbus Organization or any manufacturer. Results relate only to the item tested. Times "
    "carry the stated uncertainty; tests during which the bench was late are marked inconclusive."
)
BANNER = (
    "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Emergency stop, safe torque off, "
    "guards, enabling devices and speed monitoring must be realised in certified hardware that works without axisgate."
)
UNCERTAINTY = "one character time and 20 ms; a test in which the bench was later than that is inconclusive"
COLOURS = {"PASS": "#1a7f37", "FAIL": "#b3261e", "WARN": "#8a5a00", "INCONCLUSIVE": "#5b5b5b", "NOT RUN": "#5b5b5b"}
LABELS = {  # of the profile in the page; the JSON keeps its keys
    "name": "name",
    "source": "source",
    "ack_delay_ms (QVZ/ADT)": "acknowledgement delay QVZ/ADT, ms",
    "char_delay_ms (ZVZ/CDT)": "character delay ZVZ/CDT, ms",
    "block_wait_ms (BWZ)": "block wait time BWZ, ms",
    "connect_attempts": "connection attempts",
    "block_attempts": "block attempts",
    "open": "open (no source names it)",
}
FINE = ("PASS", "NOT RUN")
STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#1b1b1b;background:#fff}"
    "table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #ddd;padding:.35rem .5rem;text-align:left;vertical-align:top}"
    "th{background:#f3f3f3}.v{font-weight:600;white-space:nowrap}code{font:12px ui-monospace,monospace;word-break:break-word}"
    "small{color:#555}summary{cursor:pointer;color:#555}@media print{details{display:none}body{margin:0}}"
)


def as_dict(
    results: Sequence[Result],
    settings: Settings,
    port: str,
    line_format: str,
    moment: str,
    simulated: bool,
    device: Mapping[str, str],
    language: str = "en",
) -> dict[str, object]:
    """The complete report, sentences in that language, verdicts and keys unchanged; times in ms."""
    profile = settings.profile
    return {
        "kind": "axisgate line probe",
        "format": 1,
        "language": language,
        "at": moment,
        "device": {key: in_language(value, language) for key, value in device.items()},
        "port": port,
        "line_format": line_format,
        "time": in_language("virtual: the station is simulated in this process" if simulated else "real", language),
        "profile": {
            "name": profile.name,
            "source": profile.source,
            "ack_delay_ms (QVZ/ADT)": profile.ack_delay / 1e6,
            "char_delay_ms (ZVZ/CDT)": profile.char_delay / 1e6,
            "block_wait_ms (BWZ)": profile.block_wait / 1e6,
            "connect_attempts": profile.connect_attempts,
            "block_attempts": profile.block_attempts,
            "open": list(profile.open_fields),
        },
        "priority_of_station": settings.priority.name.lower(),
        "layer": settings.layer,
        "uncertainty": in_language(UNCERTAINTY, language),
        "counts": counted(results),
        "conclusion": in_language(conclusion(results, settings), language),
        "tests": [_test(result, language) for result in results],
        "text": in_language(TEXT, language),
        "banner": in_language(BANNER, language),
    }


def _test(result: Result, language: str) -> dict[str, object]:
    return {
        "name": result.case.name,
        "title": in_language(result.case.title, language),
        "verdict": result.verdict,
        "reason": in_language(result.reason, language),
        "remarks": [in_language(remark, language) for remark in result.notes.remarks],
        "times": [
            {
                "what": in_language(time.what, language),
                "ms": round(time.ns / 1e6, 3),
                "expected_ms": None if time.expected_ns is None else time.expected_ns / 1e6,
                "tolerance_ms": round(time.tolerance_ns / 1e6, 3),
            }
            for time in result.notes.times
        ],
        "characters": characters(result.notes),
        "wire": wire_text(result.notes),
        "bench_late_ms": round(result.late_ns / 1e6, 3),
        "took_ms": round(result.took_ns / 1e6, 1),
    }


def characters(notes: Notes) -> dict[str, int]:
    """Characters on the wire, by sender."""
    return {side: sum(who == side for _, who, _ in notes.wire) for side in ("us", "station")}


def wire_text(notes: Notes) -> str:
    """The traffic on the line, in order of time: > tester, < station."""
    parts, last = [], ""
    for _, who, what in sorted(notes.wire, key=lambda entry: entry[0]):
        if who != last:
            parts.append(">" if who == "us" else "<")
            last = who
        parts.append(f"[{named(what)}]" if isinstance(what, Damage) else f"{what:02X}")
    return " ".join(parts)


def to_json(report: Mapping[str, object]) -> str:
    """The report for a program."""
    return json.dumps(report, indent=1) + "\n"


def to_html(report: Mapping[str, object]) -> str:
    """The report for a person, in its own language, one file without anything from elsewhere."""
    language = str(report.get("language", "en"))

    def word(pattern: str, *values: object) -> str:
        return _e(in_language(said(pattern, *values), language))

    tests, counts = report["tests"], report["counts"]
    assert isinstance(tests, list) and isinstance(counts, dict)
    facts = "".join(f"<tr><th>{key}<td>{_e(value)}" for key, value in _facts(report, word))
    summary = ", ".join(f"{count} {word(verdict)}" for verdict, count in counts.items() if count)
    return (
        f'<!DOCTYPE html><html lang="{language}"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{word('3964R probe')} {_e(report['at'])}</title><style>{STYLE}</style>"
        f"<h1>{word('3964R probe')}</h1><p>{_e(report['at'])}: <b>{summary}</b></p><p>{_e(report['conclusion'])}</p>"
        f"{_faults(tests, word)}<table>{facts}</table>"
        f"<h2>{word('Tests')}</h2><table><tr><th>{word('Test')}<th>{word('Verdict')}<th>{word('Reason, measured times, characters')}"
        f"{''.join(_row(test, word) for test in tests)}</table>"
        f"<p><small>{_e(report['text'])}</small></p><p><small>{_e(report['banner'])}</small></p>"
    )


def _facts(report: Mapping[str, object], word: Callable[..., str]) -> Iterator[tuple[str, object]]:
    """The table above the tests: label, value."""
    profile, device = report["profile"], report["device"]
    assert isinstance(profile, dict) and isinstance(device, dict)
    yield from ((word(str(key)), value) for key, value in device.items())
    for label, key in (("Port", "port"), ("Line", "line_format"), ("Time", "time")):
        yield word(label), report[key]
    yield word("Priority of the station"), in_language(report["priority_of_station"], str(report.get("language", "en")))
    yield word("Layer"), report["layer"]
    yield word("Uncertainty"), report["uncertainty"]
    for key, value in profile.items():
        shown = ", ".join(value) or "-" if isinstance(value, list) else f"{value:g}" if isinstance(value, float) else value
        yield word("Profile: {}", LABELS.get(str(key), str(key))), shown


def _faults(tests: Sequence[Mapping[str, object]], word: Callable[..., str]) -> str:
    """The faults a reader looks for first."""
    lines = [
        f"<li><b>{_e(test['name'])}</b> <span style='color:{COLOURS[str(test['verdict'])]}'>{word(str(test['verdict']))}</span>: "
        f"{_e(test['reason'])} <small>({_e(test['title'])})</small>"
        for test in tests
        if test["verdict"] not in FINE
    ]
    return f"<h2>{word('Findings')}</h2><ul>{''.join(lines)}</ul>" if lines else f"<p>{word('No findings.')}</p>"


def _row(test: Mapping[str, object], word: Callable[..., str]) -> str:
    times, remarks, count = test["times"], test["remarks"], test["characters"]
    assert isinstance(times, list) and isinstance(remarks, list) and isinstance(count, dict)
    lines = [_e(test["reason"])] if test["reason"] else []
    lines += [_time(time, word) for time in times] + [_e(remark) for remark in remarks]
    figures = count["us"], count["station"], test["bench_late_ms"]
    lines.append(word("{} characters from us, {} from the station; bench late {} ms at most", *figures))
    verdict = str(test["verdict"])
    return (
        f"<tr><td><b>{_e(test['name'])}</b><br>{_e(test['title'])}<td class=v style='color:{COLOURS[verdict]}'>{word(verdict)}"
        f"<td>{'<br>'.join(lines)}<details><summary>{word('on the wire')}</summary><code>{_e(test['wire'])}</code></details>"
    )


def _time(time: Mapping[str, object], word: Callable[..., str]) -> str:
    figures = word("{}: {} ms", time["what"], time["ms"])
    if time["expected_ms"] is None:
        return figures
    return figures + word(" (expected {:g} \u00b1 {:.1f} ms)", time["expected_ms"], time["tolerance_ms"])


def _e(text: object) -> str:
    return html.escape(str(text))
