"""The pendant of the old control on the screen: 4 x 20 characters and its keys, at the panel of a running cell (AX-495)."""

import asyncio
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Grid, Vertical
from textual.widgets import Button, Footer, Static

from drivers.ports.base import runtime_dir
from gateway.observer.tool_link import PATIENCE_S, Gone, Link, Row
from gateway.tools.monitor.keypad import ARROWS, KEYPAD, key_of
from gateway.tools.monitor.widgets import Help

TICK_S = 0.2
SETTLED_S = 0.3  # the control reads its keys within 5 ms; what is shown follows within 200 ms
COLUMNS, LINES = 20, 4
KEYS = """0..9  .  -    as on the pendant
m, i         MODE, INFO
Enter        ENTER
Backspace    DELETE
arrows       cursor: left goes one level back, up and down scroll
A..Z         letters, for a program that reads the pendant (M and I with shift)
F2           ask for control, and give it back: mode 11.1 (reset) needs it
F1           these keys
F10, Ctrl+Q  end

m 7.3.2 Enter goes straight to "Process conditions"; m 0 Enter to the basic level;
m 0.11.4 Enter from anywhere to VFACTOR.  No key here moves an axis, and this is no enabling device."""


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
        """{screen: four lines, mode, lost_keys}."""
        return await self.ask(op="panel")

    async def press(self, key: str) -> Row:
        """The same after a key."""
        return await self.ask(op="panel", key=key)

    def close(self) -> None:
        self._link.close()


class PanelError(Exception):
    """What the panel would not do, in its words."""


def framed(lines: list[str]) -> str:
    """The display with its frame."""
    edge = "─" * COLUMNS
    return "\n".join([f"┌{edge}┐", *(f"│{line[:COLUMNS]:<{COLUMNS}}│" for line in lines), f"└{edge}┘"])


class Pendant(App[None]):
    """Keys go to the panel one after another; what it shows comes back with each, and five times a second."""

    TITLE = "axisgate pendant"
    ENABLE_COMMAND_PALETTE = False
    CSS = """
    Screen { align: center top; }
    #box { width: 44; height: auto; border: round $primary; padding: 0 1; }
    #display { width: 22; height: 6; }
    #state { height: auto; color: $text-muted; }
    #keys { grid-size: 4 5; grid-gutter: 0 1; height: 15; }
    #keys Button { width: 100%; min-width: 8; height: 3; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f1", "help", "keys", priority=True),
        Binding("f2", "control", "control", priority=True),
        Binding("f10,ctrl+q,ctrl+c", "quit", "end", priority=True),
    ]

    def __init__(self, run: str) -> None:
        super().__init__()
        self.run_name = run
        self.link = PanelLink(run)
        self.holds = False
        self.shown: Row = {"screen": [""] * LINES, "mode": "?", "lost_keys": 0}
        self._words = ""
        # kept here, not looked up: while the keys are shown or the app ends, another screen or none is in front
        self.display_box = Static(framed([""] * LINES), id="display", markup=False)
        self.state_line = Static("", id="state", markup=False)
        self._pressed: asyncio.Queue[str] = asyncio.Queue()
        self._busy = asyncio.Lock()

    def compose(self) -> ComposeResult:
        with Vertical(id="box"):
            yield self.display_box
            yield self.state_line
            with Grid(id="keys"):
                for number, name in enumerate(name for row in KEYPAD for name in row):
                    button = Button(ARROWS.get(name, name), id=f"key-{number}", name=name)
                    button.can_focus = False  # the keyboard types; Enter is ENTER
                    yield button
        yield Footer()

    async def on_mount(self) -> None:
        await self._tick()
        self.set_interval(TICK_S, self._tick)

    async def on_key(self, event: events.Key) -> None:
        name = key_of(event.key, event.character)
        if name is not None:
            event.stop()
            await self._press(name)

    async def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.name:
            await self._press(event.button.name)

    async def _press(self, name: str) -> None:
        """In the order they were pressed, each heard by the panel before the next."""
        self._pressed.put_nowait(name)
        async with self._busy:
            while not self._pressed.empty():
                await self._show(key=self._pressed.get_nowait())

    async def _tick(self) -> None:
        if self._busy.locked():
            return
        async with self._busy:
            await self._show()
            if self.holds:
                await self._alive()

    async def _show(self, key: str | None = None) -> None:
        try:
            self.shown = await (self.link.screen() if key is None else self.link.press(key))
            self._words = ""
        except (Gone, PanelError) as error:
            self._words = str(error)
        if not self.display_box.is_attached:
            return
        self.display_box.update(framed(self.shown["screen"]))
        lost = f" | {self.shown['lost_keys']} keys lost" if self.shown["lost_keys"] else ""
        control = "in control" if self.holds else "not in control"
        self.state_line.update(self._words or f"{self.run_name} | mode {self.shown['mode']} | {control}{lost}")

    # ---- control ---------------------------------------------------------------------------------------------------------
    async def _alive(self) -> None:
        """What is in control shows life; silent for a second it counts as gone (AX-312)."""
        try:
            self.holds = bool((await self.link.ask(op="alive"))["holds"])
        except (Gone, PanelError):
            self.holds = False

    async def action_control(self) -> None:
        """Ask for it, or give it back."""
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


async def once(run: str, keys: list[str]) -> Row:
    """Keys, then the present display; Gone, PanelError."""
    link = PanelLink(run)
    try:
        for key in keys:
            await link.press(key)
        if keys:
            await asyncio.sleep(SETTLED_S)
        return await link.screen()
    finally:
        link.close()
