"""The panel's 4 x 20 characters and its keys.  Source: rho 3 Releases L2923-2941, L6623-6717; rho3 7.2, AX-535, AX-536.

Each layer has a page.  A line shows the highest layer that wrote it.  A held layer keeps its lines; a released one keeps them only until a
lower layer writes there.
"""

from collections import deque
from enum import IntEnum

from gateway.pure.controllers.rho3.functions.reading import PanelReader

LINES, COLUMNS = 4, 20
KEYS = 64  # keys waiting (AX-536)
_SYSTEM_OFF = (1, 2)  # lines 2 and 3: kept free of the system's messages by bit 35


class Layer(IntEnum):
    """Who writes; the lower number wins (L2923-2934)."""

    TEST = 1
    WRITE = 2
    CODED = 3
    INFO = 4
    STANDARD = 5


def fitted(text: str) -> str:
    """A line as it is shown: cut or filled up to 20 columns."""
    return text[:COLUMNS].ljust(COLUMNS)


class Display:
    """What an operator sees and types."""

    def __init__(self) -> None:
        self._pages: dict[Layer, list[str | None]] = {layer: [None] * LINES for layer in Layer}
        self._held: set[Layer] = set()
        self._off = False
        self._saved: dict[Layer, list[str | None]] = {}
        self._written: set[int] = set()  # lines the system wrote while off
        self._selected = False
        self._keys: deque[str] = deque()
        self.lost_keys = 0
        self.reader = PanelReader()
        self.tag = ""  # at the end of line 4 (MSD active)

    # ---- pages -------------------------------------------------------------------------------------------------------------
    def hold(self, layer: Layer) -> None:
        """From now on nothing below `layer` overwrites it."""
        self._held.add(layer)

    def release(self, layer: Layer) -> None:
        """What `layer` shows may be overwritten from below."""
        self._held.discard(layer)

    def close(self, layer: Layer) -> None:
        """Remove `layer` at once and show the layers below."""
        self._held.discard(layer)
        self._pages[layer] = [None] * LINES

    def occupied(self, layer: Layer) -> bool:
        """Whether a higher layer holds the panel."""
        return any(held < layer for held in self._held)

    def write(self, layer: Layer, line: int, text: str) -> None:
        """Line 1..4 of a layer; ValueError for another line."""
        if not 1 <= line <= LINES:
            raise ValueError(f"line {line}; 1 to {LINES}")
        index, shown = line - 1, fitted(text)
        changed = self._pages[layer][index] != shown
        self._pages[layer][index] = shown
        if self._off and layer >= Layer.INFO:
            if changed or self._selected:  # a system that repeats itself has nothing newer than what was saved
                self._written.add(index)
            if index in _SYSTEM_OFF:
                return
        self._uncover(layer, index)

    def _uncover(self, layer: Layer, index: int) -> None:
        for above in Layer:
            if above < layer and above not in self._held:
                self._pages[above][index] = None

    def screen(self) -> tuple[str, ...]:
        """Four lines of 20 characters."""
        lines = [_top(self._saved if self._frozen(index) else self._pages, index) for index in range(LINES)]
        if self.tag:
            lines[3] = lines[3][: COLUMNS - len(self.tag)] + self.tag
        return tuple(lines)

    def _frozen(self, index: int) -> bool:
        """While bit 35 is set lines 2 and 3 show no later word of the system."""
        above = any(self._pages[layer][index] is not None for layer in Layer if layer < Layer.INFO)
        return self._off and index in _SYSTEM_OFF and not above

    # ---- bit 35 ------------------------------------------------------------------------------------------------------------
    def disable(self, off: bool) -> None:
        """Level of DIS_PHGM_RCI: the rising edge saves the display, the falling one brings it back (L6623-6633)."""
        if off and not self._off:
            self._saved = {layer: list(page) for layer, page in self._pages.items()}
            self._written.clear()
            self._selected = False
            self._off = True
        elif self._off and not off:
            self._off = False
            self._give_back()

    def selected(self) -> None:
        """Drop the saved content: a function was selected at the interface (L6631)."""
        self._selected = True

    def _give_back(self) -> None:
        """Lines the system wrote meanwhile show that; the others what was saved, unless a function was selected (L6631)."""
        for index in range(LINES):
            if index in self._written:
                self._uncover(Layer.INFO, index)
            elif not self._selected:
                for layer in Layer:
                    if layer not in self._held:
                        self._pages[layer][index] = self._saved[layer][index]

    # ---- keys --------------------------------------------------------------------------------------------------------------
    def press(self, key: str) -> None:
        """A key of the panel; without a reader the newest are lost and counted."""
        if len(self._keys) >= KEYS:
            self.lost_keys += 1
        else:
            self._keys.append(key)

    def read(self) -> str | None:
        """READ PHG of a program: the oldest key (L6715-6717); None: none was pressed."""
        return self._keys.popleft() if self._keys else None

    def read_begin(self) -> None:
        """READ_BEGIN PHG: forgets what was typed before."""
        self._keys.clear()

    def system_key(self) -> str | None:
        """The same for the system, which reads only while the display is its own."""
        return None if self._off else self.read()


def _top(pages: dict[Layer, list[str | None]], index: int) -> str:
    """Return the line of the highest layer that wrote it."""
    return next((text for layer in Layer if (text := pages[layer][index]) is not None), " " * COLUMNS)
