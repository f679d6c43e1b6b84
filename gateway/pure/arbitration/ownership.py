"""Who may command: one command source at a time owns the kinematic (design: section 5, Command sources and control)."""

from gateway.pure.image.reasons import Reason, Refusal

NOBODY = 0


class Ownership:
    """Command sources are numbered from 1; word 8 of every status block contains the owner's number."""

    def __init__(self) -> None:
        self.owner = NOBODY
        self._dead: set[int] = set()

    def request(self, door: int, *, at_rest: bool) -> bool:
        """Give control to `door`; True when it did not have it before.  Refused while another living command source owns it or the axes
        move."""
        if self.owner == door:
            return False
        if self.owner != NOBODY and self.owner not in self._dead:
            raise Refusal(Reason.NOT_OWNER, f"command source {self.owner}")
        if not at_rest:
            raise Refusal(Reason.NOT_AT_REST)
        self.owner = door
        return True

    def release(self, door: int, *, at_rest: bool) -> None:
        """Give control back; only at rest, and only by its owner."""
        self.demand(door)
        if not at_rest:
            raise Refusal(Reason.NOT_AT_REST)
        self.owner = NOBODY

    def demand(self, door: int) -> None:
        """Raise unless `door` owns the kinematic."""
        if self.owner != door:
            raise Refusal(Reason.NOT_OWNER, f"command source {self.owner}" if self.owner else "no command source; request control first")

    def link(self, door: int, *, alive: bool) -> None:
        """The owner keeps control while its link is dead, but then another command source may take it."""
        if alive:
            self._dead.discard(door)
        else:
            self._dead.add(door)
