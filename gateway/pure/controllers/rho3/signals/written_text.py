"""WRITE PHG and READ PHG on the display of the panel: scrolling lines, followed by the typed input."""

from gateway.pure.controllers.rho3.functions.display import COLUMNS, LINES, Display, Layer


class WrittenText:
    """Text of the programs on one display."""

    def __init__(self, display: Display) -> None:
        self._display, self._reader = display, display.reader
        self._written = ""

    def write(self, written: str) -> None:
        """Write line after line; CLS clears; the oldest lines are lost at the top."""
        _, cleared, text = written.replace("\r", "").rpartition("\f")
        self._written = (text if cleared else self._written + text)[-LINES * COLUMNS * 2 :]
        self._show()

    def echo(self) -> None:
        """Show the input typed for READ PHG after the written text."""
        reader = self._reader
        if reader.changed:
            reader.changed, echo, reader.echo = False, reader.echo, ""
            self.write(echo)

    def _show(self) -> None:
        shown = self._written + self._reader.typed
        rows = [row[at : at + COLUMNS] for row in shown.split("\n") for at in range(0, max(len(row), 1), COLUMNS)][-LINES:]
        for number in range(LINES):
            self._display.write(Layer.WRITE, number + 1, rows[number] if number < len(rows) else "")
