"""Coordination flags of the passive station: set when a job was accepted, reset by the program that used it.  Source: VIPA HB97E-CP."""

from protocols.rk512.header import Flag


class Flags:
    """The flags that are set; the same byte and bit of another CPU is another flag."""

    def __init__(self) -> None:
        self.set: set[Flag] = set()

    def locks(self, flag: Flag | None) -> bool:
        """A job that names this flag must not be carried out."""
        return flag in self.set

    def take(self, flag: Flag | None) -> None:
        """A job that names this flag was carried out."""
        if flag is not None:
            self.set.add(flag)

    def reset(self, flag: Flag) -> None:
        """The program has used the data."""
        self.set.discard(flag)
