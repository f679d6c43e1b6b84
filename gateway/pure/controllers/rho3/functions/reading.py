"""READ PHG of a program: keys of the panel are what it reads, a line up to ENTER, or one key for a CHAR (L6715-6717, AX-1121)."""

LONGEST = 80  # characters of a line, as of a TEXT


class PanelReader:
    """Receives the keys while a program reads.  wanted: type that is read, "": none; lines: for the program, oldest first; asks: the
    program has a line and has not yet requested the next.
    """

    def __init__(self) -> None:
        self.wanted = ""
        self.typed = ""
        self.echo = ""  # characters to show in addition, since the last query
        self.changed = False
        self.asks = False
        self.lines: list[str] = []

    def reads(self, base: str) -> None:
        """Set the type that a program now waits for; input typed for an ended one is dropped."""
        self.wanted, self.asks = base, False
        if not base:
            self.changed = self.changed or bool(self.typed)
            self.typed = ""

    def take(self, key: str) -> bool:
        """Whether the key is the program's; MODE, INFO and the cursor stay the system's."""
        if not self.wanted:
            return False
        if key == "ENTER":
            self._send(f"{self.typed}\r")
        elif key == "DELETE":
            self.typed = self.typed[:-1]
        elif len(key) != 1:
            return False
        elif self.wanted == "CHAR":
            self._send(key)
        else:
            self.typed = (self.typed + key)[:LONGEST]
        self.changed = True
        return True

    def _send(self, line: str) -> None:
        self.lines.append(line)
        self.echo += line.replace("\r", "\n")
        self.typed, self.wanted, self.asks = "", "", True
