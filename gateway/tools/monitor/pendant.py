"""The pendant of the old controller on the screen: its display and its keys, as the services of a running cell describe them (AX-495,
AX-1660)."""

import asyncio
from collections.abc import Awaitable
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Grid, Vertical
from textual.widgets import Button, Footer, Static

from drivers.ports.base import runtime_dir
from gateway.observer.tool_link import PATIENCE_S, Gone, Link, Row
from gateway.tools.monitor.keypad import ARROWS, Unit, key_of, keys_of
from gateway.tools.monitor.widgets import Help

TICK_S = 0.2
SETTLED_S = 0.3  # the control reads its keys within 5 ms; the display follows within 200 ms
HOLD_S = 0.15  # repeat interval of a held key; the services release one that is silent for half a second
FEW_LINES = 8  # a larger display has flat keys
FRAME = 2
KEYS = """0..9  .  -    as on the pendant
Enter        ENTER
Backspace    DELETE
arrows       cursor
F9           ask for control, and give it back (F2 where the pendant has no F2)
F8           these keys (F1 where the pendant has no F1)
F10, Ctrl+Q  end

rho 3: m MODE, i INFO, other letters for a program that reads the pendant (M and I with shift); left goes up one
level back.  m 7.3.2 Enter goes straight to "Process conditions"; m 0 Enter to the basic level; m 0.11.4 Enter
from anywhere to VFACTOR.  No key of it moves an axis.  Mode 11.1 (reset) needs control.
ROBOTstar V: Esc QUIT, PageUp and PageDown the menus, F1..F6 the function keys, letters in an entry.  Movement keys
and START act for as long as the mouse holds them, and movement keys need control.
This is not an enabling device."""


class PanelLink:
    """The panel of one run; Gone where it does not answer, PanelError for its refusals."""

    def __init__(self, run: str) -> None:
        self._link = Link(str(runtime_dir() / f"{run}-services.sock"), f"run {run}", PATIENCE_S)

    async def ask(self, **request: object) -> Row:
        """An answer without an error."""
        answer = await self._link.ask(**request)
        if "error" in answer:
            raise PanelError(str(answer["error"]))
        return answer

    async def screen(self) -> Row:
        """{screen: lines, mode, lost_keys, unit: size and keys}."""
        return await self.ask(op="panel")

    async def press(self, key: str) -> Row:
        """The same after a key."""
        return await self.ask(op="panel", key=key)

    async def hold(self, key: str, *, first: bool) -> Row:
        """The same while a key is held."""
        return await self.ask(op="panel", hold=key, first=first)

    async def release(self, key: str) -> Row:
        """The same on release."""
        return await self.ask(op="panel", release=key)

    def close(self) -> None:
        self._link.close()


class PanelError(Exception):
    """A refusal of the panel, in its words."""


def framed(lines: list[str], columns: int) -> str:
    """The display with its frame."""
    edge = "─" * columns
    return "\n".join([f"┌{edge}┐", *(f"│{line[:columns]:<{columns}}│" for line in lines), f"└{edge}┘"])


class Key(Button):
    """One key; a held one acts from the press of the mouse to its release."""

    def __init__(self, label: str, name: str, number: int, *, held: bool) -> None:
        super().__init__(label, id=f"key-{number}", name=name, disabled=not name)
        self.can_focus = False  # the keyboard types; Enter is ENTER
        self.held = held

    def on_mouse_down(self) -> None:
        if self.held and isinstance(self.app, Pendant) and self.name:
            self.capture_mouse()
            self.app.holding = self.name

    def on_mouse_up(self) -> None:
        if self.held and isinstance(self.app, Pendant):
            self.release_mouse()
            self.app.holding = ""


class Pendant(App[None]):
    """Sends keys to the panel one at a time; the display is returned with each, and five times a second."""

    TITLE = "axisgate pendant"
    ENABLE_COMMAND_PALETTE = False
    CSS = """
    Screen { align: center top; }
    #box { width: auto; height: auto; border: round $primary; padding: 0 1; }
    #display { width: auto; height: auto; }
    #state { height: auto; color: $text-muted; }
    #keys { grid-gutter: 0 1; }
    #keys Button { width: 100%; min-width: 4; height: 3; }
    #keys.flat Button { height: 1; border: none; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f1", "function('F1')", show=False, priority=True),
        Binding("f2", "function('F2')", show=False, priority=True),
        *(Binding(f"f{number}", f"function('F{number}')", show=False, priority=True) for number in range(3, 7)),
        Binding("f8", "help", "keys", priority=True),
        Binding("f9", "control", "control", priority=True),
        Binding("f10,ctrl+q,ctrl+c", "quit", "end", priority=True),
    ]

    def __init__(self, run: str) -> None:
        super().__init__()
        self.run_name = run
        self.link = PanelLink(run)
        self.holds = False
        self.holding = ""  # key that the mouse holds
        self.unit: Unit | None = None  # set once the services have reported it
        self.shown: Row = {"screen": [], "mode": "?", "lost_keys": 0}
        self._words = ""
        # kept here, not looked up: while the keys are shown or the app ends, another screen or none is in front
        self.display_box = Static("", id="display", markup=False)
        self.state_line = Static("", id="state", markup=False)
        self.key_grid = Grid(id="keys")
        self._pressed: asyncio.Queue[str] = asyncio.Queue()
        self._busy = asyncio.Lock()
        self._held = ""

    def compose(self) -> ComposeResult:
        with Vertical(id="box"):
            yield self.display_box
            yield self.state_line
            yield self.key_grid
        yield Footer()

    async def on_mount(self) -> None:
        await self._tick()
        self.set_interval(TICK_S, self._tick)
        self.set_interval(HOLD_S, self._keep)

    async def _lay_out(self, unit: Unit) -> None:
        """The keys of the unit below its display."""
        self.unit = unit
        flat = unit.lines > FEW_LINES
        rows, width = len(unit.keypad), max(unit.across * unit.key_columns, unit.columns + FRAME)
        self.key_grid.styles.grid_size_columns, self.key_grid.styles.grid_size_rows = unit.across, rows
        self.key_grid.styles.width, self.key_grid.styles.height = width, rows * (1 if flat else 3)
        self.key_grid.set_class(flat, "flat")
        padded = [name for row in unit.keypad for name in (*row, *[""] * (unit.across - len(row)))]
        await self.key_grid.mount(
            *(Key(unit.faces.get(name, ARROWS.get(name, name)), name, number, held=name in unit.held) for number, name in enumerate(padded))
        )

    async def on_key(self, event: events.Key) -> None:
        name = key_of(event.key, event.character, self.unit) if self.unit is not None else None
        if name is not None:
            event.stop()
            await self._press(name)

    async def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.name and not (isinstance(event.button, Key) and event.button.held):
            await self._press(event.button.name)

    async def action_function(self, name: str) -> None:
        """A function key of the pendant; F1 and F2 are the monitor's where it has none."""
        if self.unit is not None and name in self.unit.names:
            await self._press(name)
        elif name == "F1":
            self.action_help()
        elif name == "F2":
            await self.action_control()

    async def _keep(self) -> None:
        """Repeat a key that the mouse holds, and release it with the mouse."""
        if not (self.holding or self._held):
            return
        async with self._busy:
            if self._held and self._held != self.holding:
                await self._show(self.link.release(self._held))
                self._held = ""
            if self.holding:
                first, self._held = self._held != self.holding, self.holding
                await self._show(self.link.hold(self._held, first=first))

    async def _press(self, name: str) -> None:
        """In the order pressed, each received by the panel before the next."""
        self._pressed.put_nowait(name)
        async with self._busy:
            while not self._pressed.empty():
                await self._show(self.link.press(self._pressed.get_nowait()))

    async def _tick(self) -> None:
        if self._busy.locked():
            return
        async with self._busy:
            await self._show(self.link.screen())
            if self.holds:
                await self._alive()

    async def _show(self, asked: Awaitable[Row]) -> None:
        try:
            self.shown = await asked
            self._words = ""
        except (Gone, PanelError) as error:
            self._words = str(error)
        if not self.display_box.is_attached:
            return
        if self.unit is None and "unit" in self.shown:
            await self._lay_out(Unit.of(self.shown["unit"]))
        self.display_box.update(framed(self.shown["screen"], self.unit.columns if self.unit is not None else 0))
        lost = f" | {self.shown['lost_keys']} keys lost" if self.shown["lost_keys"] else ""
        control = "in control" if self.holds else "not in control"
        self.state_line.update(self._words or f"{self.run_name} | mode {self.shown['mode']} | {control}{lost}")

    # ---- control ---------------------------------------------------------------------------------------------------------
    async def _alive(self) -> None:
        """A client in control must send signs of life; after a second of silence it counts as gone (AX-312)."""
        try:
            self.holds = bool((await self.link.ask(op="alive"))["holds"])
        except (Gone, PanelError):
            self.holds = False

    async def action_control(self) -> None:
        """Request control, or give it back."""
        code = "release_control" if self.holds else "request_control"
        async with self._busy:
            try:
                answer = await self.link.ask(op="tool", code=code, mask=0)
                done = answer["state"] == "DONE"
                self.holds = done != self.holds if done else self.holds
                self._words = "" if done else f"control: {answer['words'].lower()} {answer['detail']}"
            except (Gone, PanelError) as error:
                self._words = str(error)
        if self._words:
            self.notify(self._words, severity="warning")

    def action_help(self) -> None:
        self.push_screen(Help(KEYS))


async def once(run: str, words: str) -> Row:
    """Send keys by name and character, then return the present display; Gone, PanelError, ValueError: what is not a key."""
    link = PanelLink(run)
    try:
        shown = await link.screen()
        keys = keys_of(words, Unit.of(shown["unit"]))
        for key in keys:
            await link.press(key)
        if keys:
            await asyncio.sleep(SETTLED_S)
        return await link.screen()
    finally:
        link.close()
