"""Attributes of the objects of user pages by element type.  Source: VAL 3 reference 14.2, L6720-6989; AX-1063."""

from html.parser import HTMLParser

from gateway.pure.languages.val3.disk import resolve

TEXT = "style.color style.fontFamily style.fontSize style.fontStyle style.fontWeight style.textAlign"
BORDER = "style.backgroundColor style.borderColor style.borderStyle style.borderWidth"
EVERY = frozenset(("className", "style.visibility"))  # and dataset.*
SUPPORTED = {
    name: frozenset(words.split())
    for name, words in {
        "a": f"href target innerHTML {BORDER} style.borderRadius {TEXT} style.textDecoration",
        "button": f"disabled innerHTML style.backgroundColor style.borderColor {TEXT}",
        "hr": "style.backgroundColor style.borderColor style.borderWidth",
        "img": f"src style.src {BORDER}",
        "input": f"disabled min max step value {BORDER} {TEXT}",
        "label": f"innerHTML {BORDER} {TEXT}",
        "pre": "innerHTML",
        "range": "disabled min max step value",
        "select": "disabled options selectedIndex value style.backgroundColor style.borderColor style.borderWidth style.color "
        "style.fontFamily style.fontSize style.fontStyle style.textAlign",
    }.items()
}
DEFAULT = "innerHTML"  # attribute of an element that the catalogue does not have


class _Objects(HTMLParser):
    """Type of each element with an id."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.types: dict[str, str] = {}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if given.get("id"):
            ranged = tag == "input" and given.get("type", "").lower() == "range"
            self.types.setdefault(given["id"], "range" if ranged else tag)


def objects_of(page: bytes | None) -> dict[str, str] | None:
    """Return element types of a page by id; None: unknown page."""
    if page is None:
        return None
    reader = _Objects()
    reader.feed(page.decode("utf-8-sig", "replace"))
    return reader.types


def page_place(folder: str, name: str) -> tuple[str, str]:
    """Folder on the disk and file of a page: in `interface` of the application, or where a VAL 3 path leads (L2825).  PathFault."""
    if "://" in name or name.startswith(("./", "../")):
        inside, _, last = resolve(name, folder).rpartition("/")
        return inside, f"{last}.html"
    return f"{folder}/interface" if folder else "interface", f"{name}.html"


def doubt(objects: dict[str, str] | None, page: str, name: str, attribute: str) -> str:
    """What the catalogue has against an attribute of an object, for the log; "" for nothing."""
    if objects is None:
        return ""  # userPage answers -1 for it
    kind = objects.get(name)
    if kind is None:
        return f"page {page} has no object {name}"
    if attribute in EVERY or attribute.startswith("dataset.") or attribute in SUPPORTED.get(kind, {DEFAULT}):
        return ""
    return f"page {page}, {name}: {attribute} is not supported for {kind}"
