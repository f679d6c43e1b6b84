"""What is typed at the PHG after a question.  Source: robotstar 8.2 (L1114-1183, L1354, L1544)."""

from dataclasses import dataclass

from gateway.pure.controllers.reis.pendant.unit import SPACE

QUESTIONS = {
    "code": "code word:",
    "step": "step:",
    "edit": "step edit:",
    "find": "search for:",
    "program": "name of the program:",
    "variable": "variable:",
    "delete": "acknowledge the program to be deleted:",
    "copy": "acknowledge the source program:",
    "rename": "acknowledge the source program:",
    "protect": "acknowledge the source program:",
    "copy to": "new program name:",
    "rename to": "new program name:",
    "protect to": "letters to lock of LAESU, - for none:",
}
MOST = 256  # characters
WIDE = 20  # of SHIFT with an arrow (L1500)


@dataclass(slots=True)
class Entry:
    """what: the question; first: the answer to the one before it, where there are two."""

    what: str
    text: str = ""
    first: str = ""
    at: int = -1  # number of characters before the cursor

    def __post_init__(self) -> None:
        self.at = len(self.text)

    @property
    def asks(self) -> str:
        """Which question is shown."""
        return f"{self.what} to" if self.first else self.what

    def shown(self, width: int) -> str:
        """As typed, with the cursor in it and in sight; a code word is not shown."""
        text = "*" * len(self.text) if self.what == "code" else self.text
        whole = f"{text[: self.at]}_{text[self.at :]}"
        return whole[max(self.at + 1 - width, 0) :][:width]

    def type(self, key: str) -> None:
        """Insert a character before the cursor, or DELETE the one before it."""
        before, behind = self.text[: self.at], self.text[self.at :]
        before = before[:-1] if key == "DELETE" else (before + (" " if key == SPACE else key))[: MOST - len(behind)]
        self.text, self.at = before + behind, len(before)

    def move(self, key: str, shift: str) -> None:
        """An arrow key: one character, 20 after SHIFT, to an end after ALT (L1500); SHIFT and ALT alone wait for it."""
        if key in ("LEFT", "RIGHT"):
            far = {"SHIFT": WIDE, "ALT": len(self.text)}.get(shift, 1)
            self.at = min(max(self.at + (far if key == "RIGHT" else -far), 0), len(self.text))
