"""Which program the cycle runs: a job is ordered once, only its pieces are taken, and it is over once (AX-322).  Pure."""

from dataclasses import dataclass


@dataclass(slots=True)
class ProgramRun:
    """job: ordered and not over, 0: none; begun: a piece of it was taken; complete: nothing more comes."""

    job: int = 0
    begun: bool = False
    complete: bool = False

    def order(self, job: int) -> None:
        """From now on pieces of this job are taken."""
        self.job, self.begun, self.complete = job, False, False

    def clear(self) -> None:
        """It is over: what still comes of it is dropped."""
        self.job, self.begun, self.complete = 0, False, False

    @property
    def waits(self) -> bool:
        """More of it has to come before it is done."""
        return self.job != 0 and not self.complete
