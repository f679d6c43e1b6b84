"""An EDS for the `canopen` package: a clean file written from the result of the tolerant reader (AX-308)."""

import io
from collections.abc import Iterable

import canopen
from canopen.objectdictionary import import_od

from protocols.canopen.dictionary import Entry, ObjectDictionary, Shape


class _Sheet(io.StringIO):
    """`canopen` detects the kind of a file by its name."""

    name = "clean.eds"


def canopen_dictionary(dictionary: ObjectDictionary | None, node: int) -> canopen.ObjectDictionary:
    """Data of a device for SDO in the `canopen` package; None: nothing is known."""
    return import_od(_Sheet(clean_sheet(dictionary)), node)


def clean_sheet(dictionary: ObjectDictionary | None) -> str:
    """An EDS without the faults of the one it was read from; names, types, access of every entry."""
    lines = ["[DeviceInfo]"]
    if dictionary is not None:
        for index, head in sorted(dictionary.heads.items()):
            entries = dictionary.subs(index)
            if entries and head.shape in (Shape.ARRAY, Shape.RECORD):
                lines += ["", f"[{index:04X}]", f"ParameterName={_plain(head.name)}", f"ObjectType={head.shape.value}"]
                lines += [f"SubNumber={len(entries)}"]
            lines += _entries(index, entries, nested=head.shape in (Shape.ARRAY, Shape.RECORD))
    return "\n".join(lines) + "\n"


def _entries(index: int, entries: Iterable[Entry], *, nested: bool) -> list[str]:
    lines: list[str] = []
    for entry in entries:
        section = f"[{index:04X}sub{entry.sub:X}]" if nested else f"[{index:04X}]"
        lines += ["", section, f"ParameterName={_plain(entry.name)}", "ObjectType=7", f"DataType={entry.type.code:#06x}"]
        lines += [f"AccessType={entry.access.value}", f"PDOMapping={int(entry.mappable)}"]
    return lines


def _plain(name: str) -> str:
    return "".join(c if c.isprintable() and c != ";" else " " for c in name).strip() or "unnamed"
