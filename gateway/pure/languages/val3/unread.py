"""Elements and attributes of files that nothing reads: a misspelt name would lose its value without a word.  Source: S8 note N01."""

import re
from collections.abc import Iterator

from gateway.pure.languages.val3.model import FIELDS, SIMPLE
from gateway.pure.languages.val3.xmltree import Element

CHILDREN: dict[str, tuple[str, ...]] = {  # of the root of each kind of file, and of what is in it
    "Project": ("Parameters", "Programs", "Database", "Libraries", "Types"),
    "Libraries": ("Library",),
    "Types": ("Type",),
    "Database": ("Datas",),
    "Datas": ("Data",),
    "Data": ("Value",),
    "Local": ("Value",),
    "Field": ("Value",),
    "Value": ("Field",),
    "Programs": ("Program",),
    "Program": ("Parameters", "Locals", "Code"),
    "Parameters": ("Parameter",),
    "Locals": ("Local",),
}
LISTS = ("Programs", "Database")  # of a project: any element with the attribute file
IGNORED = "Description"
NAMES = ("name", "alias")  # an element that has one declares something
DECLARED = frozenset(("name", "access", "type", "size", "use", "dimensions"))
VALUE = frozenset(("key", "keyHex", "value", "valueHex", "link", "fatherId", "fatherIdHex"))
PLACED = frozenset((*FIELDS["trsf"], *FIELDS["config"]))
OF_TYPE: dict[str, frozenset[str]] = {
    "trsf": PLACED,
    "frame": PLACED,
    "point": PLACED,
    "config": PLACED,
    "tool": PLACED | {"ioLink", "otime", "ctime", "open", "close", "ioOpen", "ioClose"},
    "mdesc": frozenset(FIELDS["mdesc"]) | {"tmax", "rmax"},
}
JOINT = re.compile(r"j([1-9])", re.ASCII)
AXES = {"jointrx": 6, "jointtx": 6, "jointrs": 4, "jointts": 4}
FAMILY = re.compile(r"(joint|point|config)(?:rx|rs|tx|ts)", re.ASCII | re.IGNORECASE)


def unread(root: Element) -> Iterator[tuple[Element, str, bool]]:
    """Element, sentence, whether it declares something, which is missing then."""
    yield from _inside(root, root.tag == "Project")


def _inside(parent: Element, project: bool) -> Iterator[tuple[Element, str, bool]]:
    known = CHILDREN.get(parent.tag, ())
    for each in parent.children:
        if each.tag in known:
            yield from _attributes(each)
            if not (project and each.tag in LISTS):
                yield from _inside(each, project)
        elif known and each.tag != IGNORED:
            text = f"<{each.tag}> in <{parent.tag}> is not read; known: {', '.join(f'<{tag}>' for tag in known)}"
            yield each, text, any(each.get(name) for name in NAMES)


def _attributes(each: Element) -> Iterator[tuple[Element, str, bool]]:
    if each.tag in ("Data", "Local", "Field", "Parameter"):
        if unknown := _other(each, DECLARED):
            yield each, f"'{each.get('name')}' : the attribute {unknown} is not read", False
        kind = FAMILY.sub(r"\1", each.get("type"))
        for value in each.all("Value") if kind in (*SIMPLE, *OF_TYPE, "joint") else ():
            fields = OF_TYPE.get(kind, frozenset())
            axes = AXES.get(each.get("type").lower(), 9) if kind == "joint" else 0
            if unknown := _other(value, VALUE | fields, axes):
                yield value, f"'{each.get('name')}' : the attribute {unknown} is not read", False
        access = each.get("access", "private")
        if access.lower() not in ("public", "private", ""):
            yield each, f"'{each.get('name')}' : access {access!r} is read as private; there are public and private", False


def _other(each: Element, known: frozenset[str], axes: int = 0) -> str:
    """The first attribute that is none of these; "" for none.  `axes`: of a joint."""
    for name in each.attributes:
        axis = JOINT.fullmatch(name)
        if name not in known and ":" not in name and name != "xmlns" and not (axis and int(axis[1]) <= axes):
            return name
    return ""
