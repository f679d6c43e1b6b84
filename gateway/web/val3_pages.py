"""User pages of VAL 3 applications, fit for the dashboard: no scripts, no handlers, nothing from elsewhere (AX-993).

The page is shown in a sandboxed frame that runs no scripts; what is dropped here would not run there either.
"""

import base64
import html
import pathlib
import posixpath
from collections.abc import Callable
from html.parser import HTMLParser

from gateway.pure.languages.val3.disk import PathFault
from gateway.pure.languages.val3.page_catalogue import page_place

DROPPED = frozenset("script iframe frame frameset object embed applet base meta noscript template svg math portal".split())
VOID = frozenset("area br col hr img input link source track wbr".split())
SOURCES = ("src", "href", "action", "formaction", "background", "poster", "data", "srcset", "xlink:href", "srcdoc", "ping")
IMAGES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".gif": "image/gif", ".bmp": "image/bmp"}
LARGEST = 2 << 20
Reader = Callable[[str], bytes | None]


class _Cleaner(HTMLParser):
    """Writes what may be shown."""

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
            self.out.append(f"<style>{styled(data.decode('utf-8', 'replace'))}</style>")

    def _kept(self, tag: str, name: str, value: str) -> str | None:
        if not name.replace("-", "").replace("_", "").isalnum():
            return None
        if name == "style":
            return styled(value)
        if name not in SOURCES:
            return value
        if tag == "img" and name == "src":
            kind, data = IMAGES.get(posixpath.splitext(value)[1].lower()), self._read(value)
            return f"data:{kind};base64,{base64.b64encode(data).decode()}" if kind and data is not None else None
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
            self.out.append(styled(data) if self._style else html.escape(data, quote=False))


def quoted(text: str) -> str:
    """An attribute's value."""
    return f'"{html.escape(text)}"'


def styled(text: str) -> str:
    """Styles without what loads or runs something."""
    plain = text.replace("\\", "").replace("<", "")
    return "" if any(word in plain.lower() for word in ("url(", "@import", "expression(", "behavior", "-moz-binding")) else plain


def clean(text: str, read: Reader) -> str:
    """A user page; `read`: a file beside it, None where it may not or does not exist."""
    cleaner = _Cleaner(read)
    cleaner.feed(text)
    cleaner.close()
    return "".join(cleaner.out)


def page_of(disk: pathlib.Path, folder: str, name: str) -> str | None:
    """The page NAME of the application in a folder of the disk, or where a VAL 3 path leads; None: there is none."""
    try:
        inside, page = page_place(folder, name)
    except PathFault:
        return None
    interface = (disk / inside).resolve()

    def read(file: str) -> bytes | None:
        path = (interface / file.partition("?")[0]).resolve()
        if "://" in file or not path.is_relative_to(interface) or not path.is_file() or path.stat().st_size > LARGEST:
            return None
        return path.read_bytes()

    if not interface.is_relative_to(disk.resolve()):
        return None
    data = read(page)
    return None if data is None else clean(data.decode("utf-8-sig", "replace"), read)
