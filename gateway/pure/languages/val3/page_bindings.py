"""Bindings that the page editor of s8 writes next to a page, as NAME.bindings.json (AX-1852).  The manual does not have these files."""

import json
import re
from collections.abc import Iterable, Mapping

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.named_values import NOWHERE, place_of
from gateway.pure.languages.val3.page_catalogue import page_place
from gateway.pure.languages.val3.pages import MOST, PageBoard
from gateway.pure.languages.val3.values import Container

ENDING = ".bindings.json"
DATUM = re.compile(r"(?:(\w+):)?(\w.*)")  # sInfo[0], lib:vPart[2].nCount


def bind_from_file(own: Instance, page: str) -> list[str]:
    """Apply the bindings file next to a page; return a sentence for the log for each entry that cannot be bound."""
    inside, html = page_place(own.loaded.app.path, page)
    file = html.removesuffix(".html") + ENDING
    data = own.machine.disk.read(f"{inside}/{file}" if inside else file)
    if data is None:
        return []
    try:
        found = json.loads(data.decode("utf-8-sig"))
        rows = found["bindings"]
        named = [row for row in rows[:MOST] if isinstance(row, Mapping)]
    except (ValueError, KeyError, TypeError, RecursionError):
        return [f"{file}: no bindings can be read"]
    said = [f"{file}: {each}" for each in _bound(own, own.machine.pages, page, named)]
    if found.get("events") or found.get("callbacks"):
        said.append(f"{file}: events and callbacks are not read; a program binds them")
    return said


def _bound(own: Instance, pages: PageBoard, page: str, rows: Iterable[Mapping[str, object]]) -> Iterable[str]:
    own_ones = {(each.page, each.id, each.attribute) for each in pages.bindings}  # of a program, or of the file before
    for row in rows:
        if (page, row.get("id"), row.get("attribute")) in own_ones:
            continue
        datum, size, refresh = str(row.get("data", "")), row.get("size", 1), row.get("refresh", 1)
        try:
            if not isinstance(size, int | float) or not isinstance(refresh, int | float):
                raise Rte(70, f"size {size!r}, refresh {refresh!r}")
            where = place_of(*_data(own, datum))
            warning = pages.bind(
                page, str(row.get("id", "")), str(row.get("attribute", "")), where, size, str(row.get("direction", "r")), refresh
            )
        except NOWHERE as fault:
            yield f"'{datum}' : {fault.detail if isinstance(fault, Rte) else 'data expected'}"
            continue
        if warning:
            yield warning


def _data(own: Instance, datum: str) -> tuple[Mapping[str, Container], str]:
    """Where a name is to be looked up, and the name there."""
    match = DATUM.fullmatch(datum.strip())
    if match is None:
        raise LookupError(datum)
    library, name = match.groups()
    if library is None:
        return own.data, name
    first = re.split(r"[.\[]", name, maxsplit=1)[0]
    return {first: own.public_data(library, first)}, name
