"""The door of a Modbus TCP server: RC signals by their bit numbers, and the own command block (AX-012)."""

import time
from collections.abc import Callable, Collection, Sequence

from gateway.cell_modbus import Modbus
from gateway.doors import BaseDoor
from gateway.modbus_server import ModbusServer
from gateway.pure.modbus_view import RhoView
from gateway.pure.records import InputImage, Quality
from protocols.modbus.view import View

WRITES = (5, 6, 15, 16)


class ModbusDoor(BaseDoor):
    """One Modbus TCP server."""

    view: RhoView
    server: ModbusServer
    _writer = ""  # host:port of the client that wrote last

    def listen(
        self, settings: Modbus, bind: tuple[str, int], inputs: InputImage, owned: Collection[int], flush: Callable[[], None]
    ) -> None:
        """Make view and server; not started yet.  `flush` puts orders into the ring at once."""

        def written(octets: Collection[int]) -> None:
            now = time.monotonic_ns()
            for octet in octets:
                inputs.quality[octet], inputs.stamps[octet] = Quality.GOOD, now
            flush()  # routes and the cycle have it now, not with the next tick

        def command(first: int, values: Sequence[int]) -> None:
            self.write_words(first, values, time.monotonic_ns())
            self.view.status = self.block.status_words(self.status)  # the answer to the next read is fresh without waiting for a tick
            flush()

        self.view = RhoView(inputs, owned, written, command if settings.command_block else None)
        self.view.command_words = self.block.words

        def view_for(unit: int) -> View | None:
            return self.view if unit == settings.unit else None

        self.server = ModbusServer(
            view_for,
            *bind,
            unit=settings.unit,
            allow=settings.allow or None,
            on_request=self._answered,
        )

    def _answered(self, address: str, function: int) -> None:
        """Life of this door: requests of the client that writes; until somebody has written, of any (AX-148)."""
        if function in WRITES:
            self._writer = address
        if self._writer in ("", address):
            self.heard(time.monotonic_ns())
