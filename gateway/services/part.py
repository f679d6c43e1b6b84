"""A part of the services process, which starts its parts, steps them in order with its tick, reads their status, closes them."""

from protocols.base.machine import Ns


class Part:
    """A part omits the methods it does not need."""

    async def start(self) -> None:
        """Inside the running loop."""

    def step(self, now: Ns) -> None:
        """At each tick."""

    def status(self) -> dict[str, object]:
        """For tools, by key; {}: nothing to report."""
        return {}

    async def close(self) -> None:
        """The process ends."""
