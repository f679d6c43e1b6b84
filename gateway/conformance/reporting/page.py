"""The report as one self-contained HTML file that prints: number and page n of m on each page, German or English."""

import html
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

from gateway.conformance.reporting.document import Json, cases_of
from gateway.conformance.reporting.german import in_german
from gateway.conformance.reporting.words_de import GERMAN

Word = Callable[..., str]
COLOURS = {"PASS": "#1a7f37", "FAIL": "#b3261e", "WARN": "#8a5a00", "INCONC": "#5b3b9b", "N/A": "#666", "ERROR": "#b3261e"}
FINDINGS = ("FAIL", "ERROR", "INCONC", "WARN")
TRACE = 420
LINE, CODE_LINE, ROW = 18.5, 15.5, 9.0  # heights in CSS pixels: a line of text, of a trace, the padding of a table row
ROOM, COVER_LINES = 900.0, 12  # of a sheet, without heading and footer; lines of findings on the first one with three rows about the device
WIDE, LEFT, RIGHT, CODE, IDS = 84, 29, 48, 52, 54  # characters in a line of the findings, the columns of a case, a trace, the coverage
LINES = ("3964r", "rk512", "modbus-rtu", "interop")  # suites whose port has a character format
LABORATORY = ("laboratory", "customer", "place", "date", "method", "deviations", "uncertainty", "decision_rule", "person")
DISCLAIMER, RULE = list(GERMAN)[-2:]
STYLE = """
@page{size:A4;margin:12mm}*{box-sizing:border-box}
body{font:13px/1.4 system-ui,sans-serif;color:#1b1b1b;background:#e9ecef;margin:0}
section{background:#fff;max-width:210mm;min-height:270mm;margin:8mm auto;padding:12mm;display:flex;flex-direction:column}
h1{font-size:22px;margin:.2em 0}h2{font-size:16px;margin:1em 0 .3em}table{border-collapse:collapse;width:100%;table-layout:fixed}
td,th{border-bottom:1px solid #d5d8dc;padding:.25rem .4rem;text-align:left;vertical-align:top;overflow-wrap:anywhere}
th{background:#f3f5f7;font-weight:600}.v{font-weight:700}code{font:11px ui-monospace,monospace;overflow-wrap:anywhere}
.chips span{display:inline-block;border:2px solid;border-radius:6px;padding:.15rem .6rem;margin:.15rem .3rem .15rem 0;font-weight:700}
footer{margin-top:auto;border-top:1px solid #999;padding-top:.3rem;color:#555;font-size:11px;display:flex;justify-content:space-between}
small{color:#555}ul{margin:.3em 0;padding-left:1.2em}
@media print{body{background:#fff}section{margin:0;padding:0;max-width:none;min-height:272mm;break-after:page}}
"""


def to_html(found: Mapping[str, object], language: str = "en") -> str:
    """One file, nothing from elsewhere."""
    de = language == "de"
    if de:
        found = in_german(found)

    def word(text: str, *values: object) -> str:
        pattern = GERMAN.get(text, text) if de else text
        return _e(pattern.format(*values) if values else pattern)

    findings = _sheets(_findings(found, word, de), _cover_room(found), ROOM)
    more = [f"<h2>{word('Findings')}</h2><ul>{''.join(sheet)}</ul>" for sheet in findings[1:]]
    pages = [_cover(found, findings, word), *more, *_laboratory(found, word), *_cases(found, word, de), *_coverage(found, word)]
    number = _number(found)
    footers = [
        f"<footer><span>{word('Conformance report')} {_e(number)}</span><span>{word('page')} {at} {word('of')} {len(pages)}</span></footer>"
        for at in range(1, len(pages) + 1)
    ]
    body = "".join(f"<section>{page}{footer}</section>" for page, footer in zip(pages, footers, strict=True))
    return (
        f'<!DOCTYPE html><html lang="{"de" if de else "en"}"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{word('Conformance report')} {_e(number)}</title><style>{STYLE}</style>{body}</html>\n"
    )


def _table(found: Mapping[str, object], *path: str) -> Json:
    for key in path:
        found = cast(Mapping[str, object], found.get(key) or {})
    return dict(found)


def _number(found: Mapping[str, object]) -> str:
    stated = _table(found, "bench", "report").get("number")
    return str(stated) if stated else f"{found['at']} / {str(found['sha256'])[:12]}"


def _e(text: object) -> str:
    return html.escape(str(text))


def _chip(verdict: str) -> str:
    return f"<span class=v style='color:{COLOURS.get(verdict, '#333')}'>{_e(verdict)}</span>"


def _rows(rows: Sequence[tuple[str, object]]) -> str:
    return (
        "<table><colgroup><col style='width:32%'><col></colgroup>"
        + "".join(f"<tr><th>{label}<td>{_e(value)}" for label, value in rows)
        + "</table>"
    )


def _lines(text: object, width: int) -> int:
    """Lines of a text that wraps, assuming a wide font."""
    return -(-len(str(text)) // width)


def _sheets(pieces: Sequence[tuple[str, float]], first: float, room: float) -> list[list[str]]:
    """Pieces and their heights, as many on each sheet as it holds."""
    sheets: list[list[str]] = []
    left = 0.0
    for piece, height in pieces:
        if not sheets or (height > left and sheets[-1]):
            left = room if sheets else first
            sheets.append([])
            if height > left < room:  # it does not fit the rest of the first sheet either
                left = room
                sheets.append([])
        sheets[-1].append(piece)
        left -= height
    return sheets


def _cover_room(found: Mapping[str, object]) -> float:
    rows = len(_table(found, "bench", "device")) + _lines(_table(found, "bench", "port").get("url"), 45)
    return LINE * COVER_LINES - (LINE + ROW) * max(0, rows - 5)


def _cover(found: Mapping[str, object], findings: Sequence[Sequence[str]], word: Word) -> str:
    suite, counts, device = _table(found, "suite"), _table(found, "counts"), _table(found, "bench", "device")
    shown = {word(name) if name == "waived" else name: count for name, count in counts.items() if count}
    chips = "".join(f"<span style='color:{COLOURS.get(name, '#333')}'>{count} {name}</span>" for name, count in shown.items())
    rows: list[tuple[str, object]] = [(word(str(key).replace("_", " ")), value) for key, value in device.items()] or [
        ("-", word("not stated: [device] of the bench"))
    ]
    port = _table(found, "bench", "port")
    facts = [
        (word("Suite"), f"{suite['name']} {suite['version']}"),
        (word("Port"), f"{port.get('url')}, {port.get('format')}" if suite["name"] in LINES else port.get("url")),
        (word("Seed"), "-" if found["seed"] is None else found["seed"]),
        (word("Versions"), ", ".join(f"{key} {value}" for key, value in _table(found, "versions").items())),
        (word("Check sum"), f"SHA-256 {found['sha256']}"),
    ]
    score = word("{} of {} faulty devices are found by this suite", suite["killed"], suite["mutants"])
    broken = f"<p><b>{word('The run was interrupted; what was done is reported.')}</b></p>" if found["interrupted"] else ""
    return (
        f"<h1>{word('Conformance report')}</h1><p>{_e(found['at'])}</p><h2>{word('Item tested')}</h2>{_rows(rows)}"
        f"<h2>{word('Result')}</h2><p class=chips>{chips}</p>{broken}<h2>{word('Mutant score of the suite')}</h2><p>{score}</p>"
        f"<h2>{word('Findings')}</h2>{_list(findings, word)}"
        f"<h2>{word('Bench')}</h2>{_rows(facts)}<p><small>{word(DISCLAIMER)}</small></p>"
    )


def _list(findings: Sequence[Sequence[str]], word: Word) -> str:
    if not findings:
        return f"<p>{word('No findings.')}</p>"
    more = f"<p><small>{word('Further findings are on the next page.')}</small></p>" if len(findings) > 1 else ""
    return f"<ul>{''.join(findings[0])}</ul>{more}"


def _findings(found: Mapping[str, object], word: Word, de: bool) -> list[tuple[str, float]]:
    """Worst first; those that only follow from another are counted with it.  With their heights."""
    cases = [case for case in cases_of(found) if case["verdict"] in FINDINGS and not case["caused_by"]]
    cases.sort(key=lambda case: FINDINGS.index(str(case["verdict"])))
    follow = [str(case["caused_by"]) for case in cases_of(found) if case["caused_by"]]
    lines = []
    for case in cases:
        behind = follow.count(str(case["id"]))
        more = f" <small>(+ {behind} {word('caused by')} {_e(case['id'])})</small>" if behind else ""
        text = f"{case['verdict']} {case['id']} {_summary(case, de)}: {case['reason']}{'.' * 46 if behind else ''}"
        height = LINE * (_lines(text, WIDE) + (2 if isinstance(case["waived"], dict) else 0))
        said = f"{_chip(str(case['verdict']))} <b>{_e(case['id'])}</b> {_e(_summary(case, de))}: {_e(case['reason'])}"
        lines.append((f"<li>{said}{more}{_waived(case, word)}", height))
    return lines


def _summary(case: Mapping[str, object], de: bool) -> str:
    return str(case["summary_de"] if de else case["summary"])


def _waived(case: Mapping[str, object], word: Word) -> str:
    waived = case["waived"]
    if not isinstance(waived, dict):
        return ""
    return f"<br><small>{word('waived by {} until {}: {}', waived['who'], waived['until'], waived['reason'])}</small>"


CLAUSES = {  # beginnings of clauses that name no public document
    "serial-protocols": (
        "summary of the manuals by axisgate; 3964(R): 1.1 characters, 1.2 block check, 1.3 sender, 1.4 receiver, 1.5 times, 1.6 "
        "priority; RK512: 2.1 command, 2.2 reaction, 2.3 follow-on telegrams, 2.4 error numbers, 2.5 coordination flag, 2.6 order "
        "of jobs. Manuals: Siemens CP 340 (A5E00369892), CP 341 (A5E02191071), CP 440 (A5E00057742); Bosch R500 computer "
        "interface (1070 072 131-102); VIPA CP 240 (HB97E-CP)"
    ),
    "AX-": "decision of axisgate, in its documentation (docs/decisions.md)",
}


def _laboratory(found: Mapping[str, object], word: Word) -> list[str]:
    stated = _table(found, "bench", "report")
    rows = [(word(name.replace("_", " ")), stated.get(name, "")) for name in LABORATORY]
    rows = [(label, value if label != word("decision rule") or value else RULE_OF[word("page") == "Seite"]) for label, value in rows]
    rows.append((word("Signature"), ""))
    checked = [(word(key), word(str(value))) for key, value in _table(found, "self_check").items()]
    assumed = cast(list[str], _table(found, "pics").get("assumed", []))
    stated_pics = [(_e(key), value) for key, value in _table(found, "pics", "stated").items()]
    parts: list[tuple[str, float]] = [
        (f"<h2>{word('Laboratory')}</h2>{_rows(rows)}", _height(rows)),
        (f"<h2>{word('Self-check of the bench')}</h2>{_rows(checked)}", _height(checked)),
    ]
    if stated_pics:
        parts += [(f"<h2>PICS</h2>{_rows(part)}", _height(part)) for part in _parts(stated_pics)]
    else:
        parts.append((f"<h2>PICS</h2><p>{word('Nothing was stated.')}</p>", 3 * LINE))
    named = [
        (start, word(text)) for start, text in CLAUSES.items() if any(str(case["clause"]).startswith(start) for case in cases_of(found))
    ]
    if named:
        parts.append((f"<h2>{word('Sources of the clauses')}</h2>{_rows(named)}", _height(named)))
    for part in _parts(assumed):
        listed = "".join(f"<li>{_e(text)}" for text in part)
        parts.append((f"<h2>{word('Assumed')}</h2><ul>{listed}</ul>", LINE * (3 + sum(_lines(text, WIDE) for text in part))))
    return ["".join(sheet) for sheet in _sheets(parts, ROOM, ROOM)]


def _parts(rows: Sequence[Any]) -> list[Sequence[Any]]:
    """Long lists may end on the next sheet."""
    return [rows[at : at + 20] for at in range(0, len(rows), 20)]


def _height(rows: Sequence[tuple[str, object]]) -> float:
    return 3 * LINE + sum(ROW + LINE * max(1, _lines(label, 24), _lines(value, 58)) for label, value in rows)


RULE_OF = {False: RULE, True: GERMAN[RULE]}


def _cases(found: Mapping[str, object], word: Word, de: bool) -> list[str]:
    rows = [_case(case, word, de) for case in cases_of(found)]
    return [_case_page(sheet, word) for sheet in _sheets(rows, ROOM, ROOM)]


def _case_page(rows: Sequence[str], word: Word) -> str:
    head = f"<tr><th>{word('Case')}<th>{word('Verdict')}<th>{word('Expected')}, {word('Got')}, {word('Times')}"
    widths = "<colgroup><col style='width:36%'><col style='width:11%'><col></colgroup>"
    return f"<h2>{word('Cases')}</h2><table>{widths}{head}{''.join(rows)}</table>"


def _case(case: Mapping[str, object], word: Word, de: bool) -> tuple[str, float]:
    """A row and its height."""
    lines = [str(case["reason"])] if case["reason"] else []
    if case["verdict"] in FINDINGS:
        lines += [f"{word('Expected')}: {case['expected']}", f"{word('Got')}: {case['got']}"]
    if case["caused_by"]:
        lines.append(f"{word('caused by')} {case['caused_by']}")
    lines += [_time(one) for one in cast(list[Json], case["measures"]) if one["min_ms"] is not None or one["max_ms"] is not None][:3]
    shown, right = [_e(line) for line in lines], LINE * sum(_lines(line, RIGHT) for line in lines)
    if case["verdict"] in FINDINGS and case["trace"]:
        text = str(case["trace"])
        text = text if len(text) <= TRACE else ".. " + text[-TRACE:]
        shown.append(f"<code>{_e(text)}</code>")
        right += CODE_LINE * (_lines(text, CODE) + 1)
    left = LINE * (_lines(case["id"], 23) + _lines(_summary(case, de), LEFT) + _lines(case["clause"], 36))
    waived = case["waived"]
    middle = LINE * (2 + _lines(" ".join(map(str, waived.values())), 8)) if isinstance(waived, dict) else LINE
    first = f"<td><b>{_e(case['id'])}</b><br>{_e(_summary(case, de))}<br><small>{_e(case['clause'])}</small>"
    row = f"<tr>{first}<td>{_chip(str(case['verdict']))}{_waived(case, word)}<td>{'<br>'.join(shown)}"
    return row, ROW + max(left, middle, right)


def _time(one: Mapping[str, object]) -> str:
    limits = " .. ".join("" if one[key] is None else f"{one[key]:g}" for key in ("min_ms", "max_ms"))
    return f"{one['what']}: {one['ms']:g} ms \u00b1 {one['uncertainty_ms']:g} ms [{limits}]"


def _coverage(found: Mapping[str, object], word: Word) -> list[str]:
    rows = []
    for requirement, entry in _table(found, "coverage").items():
        of = cast(Json, entry)
        cases = ", ".join(cast(list[str], of["cases"]))
        row = f"<tr><td>{_e(requirement)}<td>{_chip(str(of['verdict']))}<td>{_e(cases)}"
        rows.append((row, ROW + LINE * max(1, _lines(cases, IDS))))
    head = f"<tr><th style='width:22%'>{word('Requirement')}<th style='width:12%'>{word('Verdict')}<th>{word('Cases')}"
    sheets = _sheets(rows, ROOM - 3 * LINE, ROOM - 3 * LINE)
    rule = f"<p><small>{word(RULE)}</small></p>"
    return [f"<h2>{word('Coverage of requirements')}</h2><table>{head}{''.join(sheet)}</table>{rule}" for sheet in sheets]
