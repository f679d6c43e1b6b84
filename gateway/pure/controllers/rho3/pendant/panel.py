"""The system's side of the pendant: keys in, lines of standard operation and INFO out.  Source: rho 3 Releases L2743-2941, L3454-3560.

Follows the manual in: the mode numbers and their direct selection, CURSOR LEFT one level back, Automatic or Manual in
the basic level, the INFO texts, priorities by gateway.pure.controllers.rho3.functions.display.  The place of a line on the 4 x 20
display is axisgate's own
(AX-495), and a mode whose function is missing reports it.
"""

from typing import NamedTuple

from gateway.pure.controllers.rho3.functions.display import COLUMNS, LINES, Display, Layer
from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.controllers.rho3.functions.phg_selection import PhgSelection
from gateway.pure.controllers.rho3.functions.reading import PanelReader
from gateway.pure.controllers.rho3.functions.status_display import AUTOMATIC, MANUAL, StatusDisplay
from gateway.pure.controllers.rho3.pendant.infos import infos
from gateway.pure.controllers.rho3.pendant.modes import RESET, Mode, select, spoken, up
from gateway.pure.controllers.rho3.pendant.pages import Source, page_of
from protocols.base.machine import Ns, ms

REFRESH: Ns = ms(200)
LONGEST = 15  # characters of an entry after "Mode="
DIGITS = frozenset("0123456789")
LISTS = range(1, LINES - 1)  # lines 2 and 3


class Notice(NamedTuple):
    """Line 3 until the next key.  asks: it is a question, and a second ENTER is yes."""

    text: str = ""
    asks: bool = False


class Panel:
    """Call `step` once per cycle of the control."""

    def __init__(self, display: Display, selection: PhgSelection, statuses: StatusDisplay, source: Source, language: str = "en") -> None:
        self.reset_wanted = False  # mode 11.1 was chosen: the caller of step checks it and enters the mode
        self._display, self._selection, self._statuses = display, selection, statuses
        self._source, self._language = source, language
        self._entry: str | None = None
        self._value = False  # the entry is a number for the page, not a mode
        self._top = 0
        self._title = ""  # of the page as drawn last in this mode
        self._info: list[str] = []  # from the line shown first on
        self._mode = ""
        self._notice = Notice()
        self._lines: list[str | None] = [None] * LINES  # as last written: only changed lines cover those that a higher layer released
        self._drawn: Ns = 0

    @property
    def reader(self) -> PanelReader:
        """READ PHG of a program."""
        return self._display.reader

    @property
    def level(self) -> Mode:
        """The mode the panel is in."""
        return () if self._selection.mode == "0" else tuple(map(int, self._selection.mode.split(".")))

    def step(self, now: Ns) -> None:
        """Process the keys that the system may read, then the lines; changing values are shown five times a second."""
        fresh = self._selection.mode != self._mode
        if fresh:
            self._enter()
        if refusal := self._source.refusal():
            self.refuse(refusal)
        while (key := self._key()) is not None:
            fresh = True
            if self._entry is not None or not self.reader.take(key):
                self._take(key)
        if fresh or now - self._drawn >= REFRESH:
            self._drawn = now
            self._draw()

    def _key(self) -> str | None:
        """A program that reads has its keys also while the display is not the system's (L6715-6717)."""
        if self.reader.asks:
            return None  # typed ahead: it may be for the next READ
        return self._display.read() if self.reader.wanted else self._display.system_key()

    def refuse(self, words: str) -> None:
        """Reason why a selection is not executed; shown in line 3 until the next key."""
        self._notice = Notice(words)

    # ---- modes -----------------------------------------------------------------------------------------------------------
    def go(self, entry: str) -> None:
        """`Mode=entry`; mode 11.1 is only asked for."""
        reached = select(self.level, entry)
        if reached == RESET and self.level != RESET:
            self.reset_wanted = True
            return
        self.enter(reached)

    def enter(self, mode: Mode) -> None:
        """Into a mode, as the operator does it."""
        self._selection.mode = spoken(mode)
        self._enter()

    def _enter(self) -> None:
        self._mode = self._selection.mode
        self._entry, self._value, self._notice = None, False, Notice()
        self._top, self._title = self._source.entered(self.level), ""
        self._drawn = -REFRESH  # at once
        self._close_info()

    # ---- keys ------------------------------------------------------------------------------------------------------------
    def _take(self, key: str) -> None:
        asked, self._notice = self._notice.asks, Notice()  # any other key means no
        if asked and page_of(self.level, self._source, self._language).secret:
            self._entry, self._value = "", True  # any key --> continue (L5044-5052)
        elif self._info:
            self._in_info(key)
        elif key == "MODE":
            self._entry, self._value = "", False
        elif key == "INFO":
            self._open_info()
        elif self._entry is not None:
            self._edit(key)
        elif key == "LEFT":
            self.enter(up(self.level))
        elif key in ("UP", "DOWN"):
            self._scroll(1 if key == "DOWN" else -1)
        elif key in DIGITS or (key == "-" and page_of(self.level, self._source, self._language).edits):
            self._entry, self._value = key, page_of(self.level, self._source, self._language).edits
        elif key == "ENTER":
            self._choose(asked)

    def _choose(self, asked: bool) -> None:
        """ENTER on a row; where the page asks for it, a second one is the answer."""
        page = page_of(self.level, self._source, self._language)
        question = page.asks(self._top)
        if question and not asked:
            self._notice = Notice(question, asks=True)
        else:
            self._notice = Notice(page.choose(self._top))

    def _edit(self, key: str) -> None:
        assert self._entry is not None
        if key == "ENTER":
            entry, self._entry = self._entry, None
            if self._value:
                self._notice = Notice(page_of(self.level, self._source, self._language).put(entry, self._top))
            else:
                self.go(entry)
        elif key == "DELETE":
            self._entry = self._entry[:-1]
        elif key == "LEFT":
            self._entry = None
        elif (key in DIGITS or key == ".") and len(self._entry) < LONGEST:
            self._entry += key

    def _scroll(self, by: int) -> None:
        if self._selection.mode in (MANUAL, AUTOMATIC):
            self._statuses.scroll()  # SHIFT + arrow, forward only (L826-831)
            return
        rows = len(page_of(self.level, self._source, self._language).rows)
        self._top = (self._top + by) % rows if rows else 0  # ring scrolling, as file lists do it (L649-672)

    # ---- INFO ------------------------------------------------------------------------------------------------------------
    def _open_info(self) -> None:
        self._info = infos(self.level, self._source.conditions(), self._source.concerned())
        self._display.hold(Layer.INFO)

    def _in_info(self, key: str) -> None:
        if key == "DOWN":
            self._info = [*self._info[1:], self._info[0]]
        elif key == "UP":
            self._info = [self._info[-1], *self._info[:-1]]
        else:
            self._close_info()

    def _close_info(self) -> None:
        if self._info:
            self._info = []
            self._display.close(Layer.INFO)

    # ---- lines -----------------------------------------------------------------------------------------------------------
    def _draw(self) -> None:
        if self._info:
            shown = list(self._info)
            self._display.write(Layer.INFO, 1, "INFO")
            for line in LISTS:
                self._display.write(Layer.INFO, line + 1, shown[line - 1] if line <= len(shown) else "")
        if self._selection.mode in (MANUAL, AUTOMATIC):
            self._write(3, self._last())  # lines 1 to 3 are the status display's
            self._lines[:3] = [None] * 3
            return
        page = page_of(self.level, self._source, self._language)
        rows = page.rows
        if self._title not in ("", page.title):
            self._top = 0  # another list in the same mode
        self._title = page.title
        top = self._top % len(rows) if rows else 0
        shown = ([*rows[top:], *rows[:top]] + ["", ""])[:2]
        shown[1] = self._notice.text or (page.note(top) if rows else "") or shown[1]
        for line, text in enumerate((page.title, *shown, self._last())):
            self._write(line, text)

    def _last(self) -> str:
        """Return line 4: the typed text, else the present mode."""
        if self._entry is None:
            return ""
        if self._value and page_of(self.level, self._source, self._language).secret:
            return f"{say('phg_password', self._language)} {'*' * len(self._entry)}"
        return f"{'=' if self._value else 'Mode='}{self._entry}"

    def _write(self, line: int, text: str) -> None:
        if self._lines[line] != text:
            self._lines[line] = text
            self._display.write(Layer.STANDARD, line + 1, text[:COLUMNS])
