"""Failed attempts to send one job, and when there have been enough of them.  Source: rho 3 Releases part 1, section 7.1; AX-003, AX-004."""

from protocols.p3964r.profiles import ConnectCounter, Profile


class Attempts:
    """Attempts of the first job; they restart with each job, and when the partner has sent a complete block of its own."""

    __slots__ = ("blocks", "connects", "yielded")

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """None has failed."""
        self.connects, self.blocks = 0, 0
        self.yielded = False  # gave way in a repeat, in spite of priority

    @property
    def failed(self) -> int:
        """Connections and blocks together."""
        return self.connects + self.blocks

    def give_way(self) -> None:
        """With priority, in a repeat: yield once, otherwise both stations yield in every repeat and neither gets through."""
        self.clear()
        self.yielded = True

    def block_failed(self, counter: ConnectCounter) -> None:
        self.blocks += 1
        if counter is ConnectCounter.PER_BLOCK:
            self.connects = 0

    def exhausted(self, profile: Profile) -> bool:
        connects = self.failed if profile.connect_counter is ConnectCounter.SHARED else self.connects
        return connects >= profile.connect_attempts or self.blocks >= profile.block_attempts
