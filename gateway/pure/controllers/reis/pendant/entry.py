"""What is typed at the PHG after a question.  Source: robotstar 8.2 (L1114-1183, L1354, L1544)."""

from dataclasses import dataclass

QUESTIONS = {
    "code": "code word:",
    "step": "step:",
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
MOST = 128  # characters of a name (D-45)


@dataclass(slots=True)
class Entry:
    """what: the question; first: the answer to the one before it, where there are two."""

    what: str
    text: str = ""
    first: str = ""

    @property
    def asks(self) -> str:
        """Which question is shown."""
        return f"{self.what} to" if self.first else self.what

    @property
    def shown(self) -> str:
        """As typed; a code word is not shown."""
        return "*" * len(self.text) if self.what == "code" else self.text

    def type(self, key: str) -> None:
        """A character, or DELETE."""
        self.text = self.text[:-1] if key == "DELETE" else (self.text + key)[:MOST]
