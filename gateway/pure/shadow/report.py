"""The report of a shadow: one dictionary, the same in text and as one self-contained page (AX-493)."""

import html
from collections.abc import Iterable, Iterator, Mapping

Found = Mapping[str, object]
BANNER = (
    "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Results hold only for the "
    "commands that were executed while shadow mode was listening."
)
STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#1b1b1b;background:#fff}"
    "table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #ddd;padding:.35rem .5rem;text-align:left;vertical-align:top}"
    "th{background:#f3f3f3}.equal{color:#1a7f37;font-weight:600}.differs{color:#b3261e;font-weight:600}small{color:#555}"
    "@media (prefers-color-scheme:dark){body{background:#16191d;color:#e8e8e8}th{background:#262b31}.equal{color:#5fd07e}"
    ".differs{color:#ff8a80}small{color:#b0b0b0}}"
)


def report(cell: Found, lines: Found, buses: Found, left_out: Iterable[str]) -> dict[str, object]:
    """`cell`: name, file; `lines`, `buses`: what services and cycle kept."""
    found_lines = [line for line in _list(lines.get("lines")) if isinstance(line, dict)]
    blocks = [block for line in found_lines for block in _list(line.get("blocks"))]
    telegrams = _list(buses.get("telegrams"))
    differences = sum(len(_list(_of(block, "places"))) for block in (*blocks, *telegrams))
    numbers = sum(_whole(_of(line.get("telegrams", {}), "other_number")) for line in found_lines)
    return {
        "kind": "axisgate shadow",
        "format": 1,
        **cell,
        "heard_s": lines.get("heard_s", 0.0),
        "compared": bool(blocks),
        "equal": bool(blocks) and not differences and not numbers,
        "differences": differences + numbers,
        "lines": found_lines,
        "buses": dict(buses),
        "left_out": list(left_out),
        "text": BANNER,
    }


# ---- text ------------------------------------------------------------------------------------------------------------
def as_text(found: Found) -> str:
    """For a terminal."""
    return "\n".join(_sentences(found)) + "\n"


def _sentences(found: Found) -> Iterator[str]:
    yield f"shadow of {found['cell']} ({found['file']}): {_real(found['heard_s']):.1f} s"
    for line in _list(found["lines"]):
        yield from _line_sentences(line)
    buses = found["buses"]
    if _of(buses, "syncs") is not None:
        urls = ", ".join(str(url) for url in _list(_of(buses, "buses")))
        yield f"buses {urls}: {_of(buses, 'syncs')} SYNCs received, silent {_of(buses, 'silences')} times"
        for block in _list(_of(buses, "telegrams")):
            yield from _block_sentences(block)
    for words in _list(found["left_out"]):
        yield f"left out: {words}"
    if not found["compared"]:
        yield "nothing was compared: no FETCH and no read was answered on a tap; are both taps the right way round?"


def _line_sentences(line: object) -> Iterator[str]:
    telegrams = _of(line, "telegrams")
    other = _whole(_of(telegrams, "other_number"))
    if _of(line, "kind") == "modbus":
        yield (
            f"modbus {_of(line, 'line')}: {_of(line, 'characters')} bytes, {_of(telegrams, 'heard')} requests of the PLC, "
            f"{_of(telegrams, 'answered')} answers of the old controller, {other} of them refused differently from axisgate"
        )
    else:
        yield _serial_sentence(line, telegrams, other)
    if other:
        yield f"  the first one: {_of(line, 'first_other_number')}"
    if not _of(line, "connected"):
        yield f"  a tap is missing {_of(line, 'why') or ''}".rstrip()
    for block in _list(_of(line, "blocks")):
        yield from _block_sentences(block)


def _serial_sentence(line: object, telegrams: object, other: int) -> str:
    return (
        f"line {_of(line, 'line')}: {_of(line, 'characters')} characters, {_of(telegrams, 'heard')} telegrams from the PLC, "
        f"{_of(telegrams, 'answered')} answers of the old controller, {other} of them with another error number than axisgate's"
    )


def _block_sentences(block: object) -> Iterator[str]:
    yield (
        f"{_of(block, 'block')}: equal in {_percent(_of(block, 'equal_percent'))} of {_real(_of(block, 'time_s')):.1f} s, "
        f"{_of(block, 'answers')} times received, the last {_real(_of(block, 'age_s')):.1f} s ago"
    )
    for place in _list(_of(block, "places")):
        yield f"  {title(place)}: {difference(place)}"


def title(place: object) -> str:
    """ "D 0.8 move.busy"."""
    return f"{_of(place, 'place')} {_of(place, 'name')}".rstrip()


def difference(place: object) -> str:
    """How it differs, in words."""
    counts = _of(place, "counts")
    if counts is not None:
        return f"counted {_of(counts, 'there')} times there, {_of(counts, 'here')} times here"
    parts = [f"equal in {_percent(_of(place, 'equal_percent'))}"]
    later, earlier, never = _real(_of(place, "later_ms")), _real(_of(place, "earlier_ms")), _whole(_of(place, "never"))
    if later or earlier:
        ways = [f"{ms:g} ms ({word})" for ms, word in ((later, "axisgate later"), (earlier, "axisgate earlier")) if ms]
        parts.append(f"differs by {' and '.join(ways)}")
    if never:
        parts.append(f"{never} times axisgate did not have it")
    if _of(place, "largest"):
        parts.append(f"off by at most {_real(_of(place, 'largest')):g}")
    first = _of(place, "first")
    if first is not None:
        parts.append(f"first after {_real(_of(first, 'at_s')):.3f} s: there {_of(first, 'there')}, here {_of(first, 'here')}")
    return ", ".join(parts)


def _percent(value: object) -> str:
    """Never 100 % while something differs."""
    share = _real(value)
    return "100 %" if share == 100.0 else f"{min(share, 99.99):.2f} %"


# ---- page ------------------------------------------------------------------------------------------------------------
def as_html(found: Found) -> str:
    """One page without anything from elsewhere."""
    name = html.escape(str(found["cell"]))
    verdict = ("equal", "equal") if found["equal"] else ("differs", f"{found['differences']} differences")
    if not found["compared"]:
        verdict = ("differs", "nothing was compared")
    body = [f"<h1>Shadow of {name}</h1>", f'<p class="{verdict[0]}">{verdict[1]}</p>']
    body.append(f"<p>{html.escape(str(found['file']))}, {_real(found['heard_s']):.1f} s</p>")
    for line in _list(found["lines"]):
        kind = "Modbus" if _of(line, "kind") == "modbus" else "Line"
        body.append(f"<h2>{kind} {html.escape(str(_of(line, 'line')))}</h2>")
        body.append(f"<p>{html.escape(next(_line_sentences(line)))}</p>")
        body += [_table(block) for block in _list(_of(line, "blocks"))]
    telegrams = _list(_of(found["buses"], "telegrams"))
    if telegrams:
        body += ["<h2>Buses</h2>", *(_table(block) for block in telegrams)]
    body.append("<h2>Left out</h2><ul>" + "".join(f"<li>{html.escape(str(words))}</li>" for words in _list(found["left_out"])) + "</ul>")
    body.append(f"<p><small>{html.escape(BANNER)}</small></p>")
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>Shadow of {name}</title>'
    return f'<!doctype html><html lang="en"><head>{head}<style>{STYLE}</style></head><body>{"".join(body)}</body></html>\n'


def _table(block: object) -> str:
    places = _list(_of(block, "places"))
    rows = "".join(f"<tr><td>{html.escape(title(place))}</td><td>{html.escape(difference(place))}</td></tr>" for place in places)
    kind = "differs" if places else "equal"
    words = html.escape(next(_block_sentences(block)))
    return f'<p class="{kind}">{words}</p>' + (f"<table><tr><th>Place</th><th>Difference</th></tr>{rows}</table>" if rows else "")


# ---- JSON without classes --------------------------------------------------------------------------------------------
def _of(found: object, key: str) -> object:
    return found.get(key) if isinstance(found, Mapping) else None


def _list(found: object) -> list[object]:
    return list(found) if isinstance(found, list | tuple) else []


def _real(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def _whole(value: object) -> int:
    return value if isinstance(value, int) else 0
