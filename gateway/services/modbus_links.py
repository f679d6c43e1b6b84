"""Reports about the Modbus devices polled by a cell (clients and couplers): in the journal once per change, on the page the present state.

A device that was never reached and a read that a device refuses leave a value old although the line works: they are reported as well.
"""

from gateway.links.modbus.client import Group, Link, ModbusClient
from gateway.runtime.journal import Journal
from protocols.base.machine import Ns, ms
from protocols.modbus.view import Kind

TABLES = {Kind.COILS: "coils", Kind.DISCRETE_INPUTS: "discrete inputs", Kind.INPUT_REGISTERS: "input registers",
          Kind.HOLDING_REGISTERS: "holding registers"}  # fmt: skip
PATIENCE: Ns = ms(3000)  # after the start: a device that boots with the cell is not reported
SHOWN = 8  # refused requests of one link


class LinkReports:
    """Reports of one link; its client reports through it."""

    def __init__(self, journal: Journal, title: str, link: Link) -> None:
        self._journal, self._title, self._link = journal, title, link
        self._away = ""  # reported reason of the missing connection; "": connected, or nothing was reported
        self._started: Ns | None = None
        self._writes: dict[str, str] = {}  # refused writes, by the value to write

    def device(self, name: str, alive: bool) -> None:
        self._write(f"device {name} {'answers' if alive else 'does not answer'}")

    def read(self, group: Group, words: str) -> None:
        """A device refuses a group, or no longer."""
        self._write(f"device {group.device}, {place(group)}: {f'the read is refused: {words}' if words else 'read again'}")

    def written(self, device: str, what: str, words: str) -> None:
        """How a write was refused; "": it was accepted."""
        what = f"{device}, {what}"
        if words == self._writes.get(what, ""):
            return
        self._writes.pop(what, None)
        if words:
            self._writes[what] = words
        self._write(f"device {what}: {f'the write is refused: {words}' if words else 'written again'}")

    def step(self, client: ModbusClient, now: Ns) -> None:
        """A connection that cannot be made is reported once, and when it is made after all."""
        self._started = now if self._started is None else self._started
        if client.connected and self._away:
            self._away = ""
            self._write(f"connected to {self._link.url}")
        elif not client.connected and not self._away and now - self._started >= PATIENCE:
            self._away = client.why
            self._write(f"no connection to {self._link.url}: {client.why}; it is tried again until it exists")

    def status(self, client: ModbusClient) -> dict[str, object]:
        """For tools and the page."""
        devices = {
            name: {
                "unit": seen.device.unit,
                "alive": seen.alive and client.connected,
                "dead": seen.dead,
                "losses": seen.losses,
                "requests": seen.requests,
                "timeouts": seen.timeouts,
                "exceptions": seen.exceptions,
            }
            for name, seen in client.devices.items()
        }
        refused = [f"{group.device}, {place(group)}: {words}" for group, words in client.refusals()]
        refused += [f"{what}: {words}" for what, words in self._writes.items()]
        shown = [*refused[:SHOWN], *([f"and {len(refused) - SHOWN} more"] if len(refused) > SHOWN else [])]
        return {"url": self._link.url, "connected": client.connected, "why": client.why, "devices": devices, "refused": shown}

    def _write(self, words: str) -> None:
        self._journal.write("link", f"{self._title}: {words}")


def place(group: Group) -> str:
    """Where a group is read, by protocol addresses."""
    last = group.address + group.count - 1
    return f"{TABLES[group.kind]} {group.address}" + (f"..{last}" if last > group.address else "")
