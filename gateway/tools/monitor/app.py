"""The monitor on the screen: four tabs, five looks a second.  It looks and never commands (AX-494)."""

import asyncio
import time
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Footer, Input, Static, TabbedContent, TabPane

from gateway.tools.monitor.look import FILTERS, TABS, Look, NoRun
from gateway.tools.monitor.widgets import Help, LiveTable

TICK_S = 0.2
SUPERVISOR_S = 1.0
KEYS = """1 2 3 4      axes, signals, lines, errors
Tab, arrows  move between search, tabs and rows
/            search among all signals: every word must occur in a name, address, text or use
f            filter of the signals: all, on, forced, old
space        freeze the display, and resume
?            these keys
q            end

Nothing here moves or changes the machine; a stop is given at the machine, at the page, or by
axisgate's other commands.  Old and bad values are said in words: colours only repeat them."""


class Monitor(App[None]):
    """`look` is attached already."""

    TITLE = "axisgate monitor"
    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = "LiveTable"
    CSS = """
    #head { height: 1; background: $panel; padding: 0 1; }
    #search { display: none; height: 3; }
    #search.open { display: block; }
    LiveTable { height: 1fr; border: round $primary; }
    #lines-sources { height: 12; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("1", "tab('axes')", "axes", show=False),
        Binding("2", "tab('signals')", "signals", show=False),
        Binding("3", "tab('lines')", "lines", show=False),
        Binding("4", "tab('errors')", "errors", show=False),
        Binding("slash", "search", "search"),
        Binding("f", "filter", "filter"),
        Binding("space", "hold", "hold"),
        Binding("escape", "leave", "leave the search", show=False),
        Binding("question_mark", "help", "keys"),
        Binding("q", "quit", "end"),
    ]

    def __init__(self, look: Look, tab: str = "axes") -> None:
        super().__init__()
        self.look, self._first = look, tab
        self.held = False
        self.looks = 0
        self._asked = 0.0
        self._busy = asyncio.Lock()
        # kept here, not looked up: while the keys are shown or the app ends, another screen or none is in front
        self.line = Static(id="head", markup=False)
        self.box = Input(placeholder="name, address, words ...", id="search", disabled=True)
        self.tabs = TabbedContent(initial=tab)
        self.sources = LiveTable("lines-sources")
        self.tables = {each: LiveTable(f"table-{each}") for each in TABS}

    def compose(self) -> ComposeResult:
        yield self.line
        yield self.box
        with self.tabs:
            for number, tab in enumerate(TABS, 1):
                with TabPane(f"{number} {tab}", id=tab):
                    if tab == "lines":
                        yield self.sources
                    yield self.tables[tab]
        yield Footer()

    async def on_mount(self) -> None:
        await self.refresh_look()
        self.set_interval(TICK_S, self.refresh_look)

    # ---- display -----------------------------------------------------------------------------------------------------
    @property
    def tab(self) -> str:
        """The one in front."""
        return self.tabs.active or self._first

    @property
    def _on_screen(self) -> bool:
        """The widgets are on a screen: neither before the start nor after the end."""
        return self.line.is_attached and self.tables[self.tab].is_attached

    async def refresh_look(self) -> None:
        """One look; a slow one does not queue up."""
        if self.held or self._busy.locked() or not self._on_screen:
            return
        async with self._busy:
            try:
                if time.monotonic() - self._asked > SUPERVISOR_S:
                    self._asked = time.monotonic()
                    if not await self.look.still():
                        raise NoRun(f"run {self.look.name} has ended; it is waited for (q ends)")
                await self._draw()
            except NoRun as gone:
                self.line.update(str(gone))

    async def _draw(self) -> None:
        tab = self.tab
        tables = await self.look.table(tab)
        if not self._on_screen:
            return
        self.line.update(self.look.head())
        if tab == "lines":
            self.sources.show(tables[0])
        self.tables[tab].show(tables[-1])
        self.looks += 1

    async def on_tabbed_content_tab_activated(self) -> None:
        await self.refresh_look()

    async def on_input_changed(self, event: Input.Changed) -> None:
        self.look.search = event.value
        await self.refresh_look()

    def on_input_submitted(self) -> None:
        self.tables["signals"].focus()

    # ---- keys ------------------------------------------------------------------------------------------------------------
    def action_tab(self, name: str) -> None:
        self.tabs.active = name

    def action_search(self) -> None:
        self.action_tab("signals")
        box = self.box
        box.disabled = False
        box.add_class("open")
        box.focus()

    def action_leave(self) -> None:
        box = self.box
        box.value = ""
        box.remove_class("open")
        box.disabled = True
        self.tables[self.tab].focus()

    async def action_filter(self) -> None:
        self.look.filter = FILTERS[(FILTERS.index(self.look.filter) + 1) % len(FILTERS)]
        self.action_tab("signals")
        await self.refresh_look()

    def action_hold(self) -> None:
        self.held = not self.held
        if self.held:
            self.line.update(f"HELD (space resumes) | {self.look.head()}")

    def action_help(self) -> None:
        self.push_screen(Help(KEYS))
