"""The probe's report as JSON and as one self-contained HTML page."""

import html
import json
from collections.abc import Mapping, Sequence

from gateway.line_tools.bench import Notes, named
from gateway.line_tools.probe import Result, Settings, counted
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
COLOURS = {"PASS": "#1a7f37", "FAIL": "#b3261e", "WARN": "#8a5a00", "INCONCLUSIVE": "#5b5b5b", "NOT RUN": "#5b5b5b"}
STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#1b1b1b;background:#fff}"
    "table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #ddd;padding:.35rem .5rem;text-align:left;vertical-align:top}"
    "th{background:#f3f3f3}.v{font-weight:600;white-space:nowrap}code{font:12px ui-monospace,monospace;word-break:break-word}"
    "small{color:#555}summary{cursor:pointer;color:#555}@media print{details{display:none}body{margin:0}}"
)


def as_dict(
    results: Sequence[Result], settings: Settings, port: str, line_format: str, moment: str, simulated: bool, device: Mapping[str, str]
) -> dict[str, object]:
    """Everything the report says; times in ms."""
    profile = settings.profile
    return {
        "kind": "axisgate line probe",
        "format": 1,
        "at": moment,
        "device": dict(device),
        "port": port,
        "line_format": line_format,
        "time": "virtual: the station is simulated in this process" if simulated else "real",
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
        "uncertainty": "one character time and 20 ms; a test in which the bench was later than that is inconclusive",
        "counts": counted(results),
        "tests": [_test(result) for result in results],
        "text": TEXT,
        "banner": BANNER,
    }


def _test(result: Result) -> dict[str, object]:
    return {
        "name": result.case.name,
        "title": result.case.title,
        "verdict": result.verdict,
        "reason": result.reason,
        "remarks": result.notes.remarks,
        "times": [
            {
                "what": time.what,
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
    """What was on the line, in order of the moments: > ours, < the station's."""
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
    """The report for a person, one file without anything from elsewhere."""
    tests = report["tests"]
    assert isinstance(tests, list)
    counts, profile, device = report["counts"], report["profile"], report["device"]
    assert isinstance(counts, dict) and isinstance(profile, dict) and isinstance(device, dict)
    facts = {**device, "Port": report["port"], "Line": report["line_format"], "Time": report["time"]}
    facts |= {"Priority of the station": report["priority_of_station"], "Layer": report["layer"], "Uncertainty": report["uncertainty"]}
    facts |= {f"Profile: {key}": value if not isinstance(value, list) else ", ".join(value) or "-" for key, value in profile.items()}
    summary = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    return (
        '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>3964R probe {_e(report['at'])}</title><style>{STYLE}</style>"
        f"<h1>3964R probe</h1><p>{_e(report['at'])}: <b>{_e(summary)}</b></p>"
        f"<table>{''.join(f'<tr><th>{_e(key)}<td>{_e(value)}' for key, value in facts.items())}</table>"
        "<h2>Tests</h2><table><tr><th>Test<th>Verdict<th>Reason, measured times, characters"
        f"{''.join(_row(test) for test in tests)}</table>"
        f"<p><small>{_e(report['text'])}</small></p><p><small>{_e(report['banner'])}</small></p>"
    )


def _row(test: Mapping[str, object]) -> str:
    times, remarks, count = test["times"], test["remarks"], test["characters"]
    assert isinstance(times, list) and isinstance(remarks, list) and isinstance(count, dict)
    lines = [str(test["reason"])] if test["reason"] else []
    lines += [_time(time) for time in times] + remarks
    lines.append(f"{count['us']} characters from us, {count['station']} from the station; bench late {test['bench_late_ms']} ms at most")
    verdict = str(test["verdict"])
    return (
        f"<tr><td><b>{_e(test['name'])}</b><br>{_e(test['title'])}<td class=v style='color:{COLOURS[verdict]}'>{_e(verdict)}"
        f"<td>{'<br>'.join(_e(line) for line in lines)}<details><summary>on the wire</summary><code>{_e(test['wire'])}</code></details>"
    )


def _time(time: Mapping[str, object]) -> str:
    expected = "" if time["expected_ms"] is None else f" (expected {time['expected_ms']:g} ± {time['tolerance_ms']:.1f} ms)"
    return f"{time['what']}: {time['ms']} ms{expected}"


def _e(text: object) -> str:
    return html.escape(str(text))
