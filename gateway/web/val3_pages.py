"""User pages of VAL 3 applications, fit for the dashboard: no scripts, no handlers, nothing from other hosts (AX-993).

The page is shown in a sandboxed frame that runs no scripts; the parts removed here would not run there either.
"""

import base64
import html
import pathlib
import posixpath
import re
from collections.abc import Callable
from html.parser import HTMLParser
from urllib.parse import unquote

from gateway.pure.languages.val3.disk import PathFault
from gateway.pure.languages.val3.page_catalogue import page_place

DROPPED = frozenset("script iframe frame frameset object embed applet base meta noscript template svg math portal".split())
VOID = frozenset("area br col hr img input link source track wbr".split())
SOURCES = ("src", "href", "action", "formaction", "background", "poster", "data", "srcset", "xlink:href", "srcdoc", "ping")
IMAGES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".gif": "image/gif", ".bmp": "image/bmp"}
LARGEST = 2 << 20
ADDRESS = re.compile(r"""url\(\s*(["']?)([^"')]*)\1\s*\)""", re.IGNORECASE)  # url(lamp.png) in a style
LOADING = re.compile(r"@import|image-set\(|expression\(|-moz-binding|(?<![\w-])behavior\s*:", re.IGNORECASE)
ELSEWHERE = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:|//)", re.IGNORECASE)
Reader = Callable[[str], bytes | None]


class _Cleaner(HTMLParser):
    """Writes the permitted parts."""

    def __init__(self, read: Reader) -> None:
        super().__init__(convert_charrefs=True)
        self.out: list[str] = []
        self._read = read
        self._dropping = ""
        self._depth = 0
        self._style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if self._dropping:
            self._depth += tag == self._dropping
            return
        if tag in DROPPED:
            if tag not in VOID | {"base", "meta", "embed"}:
                self._dropping, self._depth = tag, 1
            return
        given = {name: value or "" for name, value in attrs}
        if tag == "link":
            self._sheet(given)
            return
        self._style = tag == "style"
        kept = [(name, self._kept(tag, name, value)) for name, value in given.items() if not name.startswith("on")]
        self.out.append(f"<{tag}{''.join(f' {name}={quoted(value)}' for name, value in kept if value is not None)}>")

    def _sheet(self, given: dict[str, str]) -> None:
        data = self._read(given.get("href", "")) if "stylesheet" in given.get("rel", "").lower() else None
        if data is not None:
            self.out.append(f"<style>{styled(data.decode('utf-8', 'replace'), self._read, posixpath.dirname(given['href']))}</style>")

    def _kept(self, tag: str, name: str, value: str) -> str | None:
        if not name.replace("-", "").replace("_", "").isalnum():
            return None
        if name == "style":
            return styled(value, self._read)
        if name not in SOURCES:
            return value
        if tag == "img" and name == "src":
            return inlined(value, self._read)
        return value if name == "href" and value.startswith("#") else None

    def handle_endtag(self, tag: str) -> None:
        if self._dropping:
            self._depth -= tag == self._dropping
            if self._depth <= 0:
                self._dropping = ""
            return
        if tag not in DROPPED and tag not in VOID:
            self._style = False
            self.out.append(f"</{tag}>")

    def handle_data(self, data: str) -> None:
        if not self._dropping:
            self.out.append(styled(data, self._read) if self._style else html.escape(data, quote=False))


def quoted(text: str) -> str:
    """An attribute's value."""
    return f'"{html.escape(text)}"'


def inlined(file: str, read: Reader) -> str | None:
    """An image next to the page as a data URL; None: no such image."""
    kind = IMAGES.get(posixpath.splitext(file.partition("?")[0])[1].lower())
    data = read(file) if kind else None
    return None if data is None else f"data:{kind};base64,{base64.b64encode(data).decode()}"


def styled(text: str, read: Reader, folder: str = "") -> str:
    """Styles without active content; images next to them are embedded.  folder: of the file of styles, seen from the page."""
    plain = text.replace("\\", "").replace("<", "")
    if LOADING.search(plain) or any(ELSEWHERE.match(found[2]) for found in ADDRESS.finditer(plain)):
        return ""

    def taken(found: re.Match[str]) -> str:
        image = inlined(posixpath.join(folder, found[2].strip()), read)
        return "none" if image is None else f"url({image})"

    made, left = ADDRESS.sub(taken, plain), ADDRESS.sub("", plain)
    return "" if "url(" in left.lower() else made


def clean(text: str, read: Reader) -> str:
    """A user page without active content; `read`: returns a file next to it, None if it is not allowed or does not exist."""
    cleaner = _Cleaner(read)
    cleaner.feed(text)
    cleaner.close()
    return "".join(cleaner.out)


def page_of(disk: pathlib.Path, folder: str, name: str) -> str | None:
    """The page NAME of the application in a folder of the disk, or where a VAL 3 path leads; None: there is none."""
    placed = _placed(disk, folder, name)
    if placed is None:
        return None
    read, page = placed
    data = read(page)
    return None if data is None else clean(data.decode("utf-8-sig", "replace"), read)


def image_of(disk: pathlib.Path, folder: str, name: str, file: str) -> str | None:
    """An image next to that page as a data URL; None: no such image."""
    placed = _placed(disk, folder, name)
    return None if placed is None else inlined(file, placed[0])


def _placed(disk: pathlib.Path, folder: str, name: str) -> tuple[Reader, str] | None:
    """A reader of the files next to a page, and the page's file name."""
    try:
        inside, page = page_place(folder, name)
    except PathFault:
        return None
    room = _cased(disk.resolve(), inside)
    if not room.is_relative_to(disk.resolve()):
        return None
    beside, _, last = page.rpartition("/")

    def read(file: str) -> bytes | None:
        if "://" in file or "\0" in file:
            return None
        path = _cased(room, posixpath.normpath(posixpath.join(beside, unquote(file.partition("?")[0]))))
        return path.read_bytes() if path.is_relative_to(room) and path.is_file() and path.stat().st_size <= LARGEST else None

    return read, last


def _cased(folder: pathlib.Path, inside: str) -> pathlib.Path:
    """A path below a folder; names are compared without case, as on the controller."""
    path = folder
    for part in inside.split("/"):
        exact = path / part
        if not exact.exists() and path.is_dir():
            exact = next((each for each in sorted(path.iterdir()) if each.name.lower() == part.lower()), exact)
        path = exact
    return path.resolve()
