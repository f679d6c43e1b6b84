"""Writes docs/guide/dialects.md from the profiles; a test compares.  `python docs/dialects.py`."""

import pathlib

from gateway.assembly.line_dialects import rk512_dialect
from gateway.pure.cell.cell import Line
from protocols.p3964r.profiles import PROFILES, Profile

PAGE = pathlib.Path(__file__).parent / "guide" / "dialects.md"
HEAD = """# Dialects of 3964, 3964R, RK512 and BUEP64

Written by docs/dialects.py from the tables the program runs with. `profile = "NAME"` in a `[[line]]`; `-tcp` at the end adds 500 ms for a
serial server (AX-224); `protocol = "3964"` leaves the block check out; [line.times] and [line.choices] set single
values (docs/guide/lines.md). QVZ = ADT = acknowledgement delay, ZVZ = CDT = character delay,
BWZ = block wait time (VIPA: wait for the reaction instead). Times in ms; * = no source names it [open].
BUEP19E is not offered: public sources give its job parameters and fault numbers, not its bytes on the line.

| Profile | QVZ 3964R | QVZ 3964 | ZVZ | BWZ | Connect | Block | Priority | Stray | No buffer | RK512: byte 6, bytes, reaction | Source |
|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def row(profile: Profile) -> str:
    """One line of the table."""

    def shown(name: str) -> str:
        value = getattr(profile, name)
        text = f"{value // 1_000_000}" if name.endswith(("delay", "plain", "wait")) else str(getattr(value, "name", value)).lower()
        return text + ("*" if name in profile.open_fields else "")

    names = ("ack_delay", "ack_delay_plain", "char_delay", "block_wait", "connect_attempts", "block_attempts", "priority", "stray")
    poll = f", looks every {profile.no_buffer_poll // 1_000_000}" if profile.no_buffer_poll else ""
    dialect = rk512_dialect(Line("line", "sim", profile=profile.name))
    rk512 = f"{dialect.db_address_unit}, {dialect.most_bytes}, {'yes' if dialect.reaction else 'no'}"
    cells = [profile.name, *map(shown, names), shown("no_buffer_wait") + poll, rk512, profile.source]
    return f"| {' | '.join(cells)} |"


def page() -> str:
    """The whole page."""
    return HEAD + "\n".join(row(profile) for profile in PROFILES.values()) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
