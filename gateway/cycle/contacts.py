"""Contacts in the cycle: CiA 401 couplers on its buses show the result of the completed cycle, and their inputs are published."""

from collections.abc import Mapping, Sequence

from drivers.drives.family import BusFamily
from gateway.assembly.contact_regions import MARKS_LAYOUT
from gateway.assembly.contacts import COUPLER, outputs_of
from gateway.pure.buses.cia401 import CouplerFamily
from gateway.pure.buses.contacts import SAID_LAYOUT, Outputs, Said, pack_said, unpack_said
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.controllers.rho3.can.ledger import LEDGER_LAYOUT, Ledger
from gateway.pure.image.records.cell import RC_BYTES, CellState, Quality
from gateway.runtime.regions import RegionReader, RegionWriter
from protocols.base.machine import Ns, ms

SERVICES_GONE: Ns = ms(250)


class CycleContacts:
    """`turn` once per completed cycle, before the next burst is made."""

    def __init__(self, cell: Cell, families: Sequence[CouplerFamily], fds: Mapping[str, int], p5_ms: int) -> None:
        self._families = families
        self._outputs = Outputs(outputs_of(cell, COUPLER, p5_ms), len(cell.axis))
        self._said = RegionReader(fds["io_out"], "io_out", SAID_LAYOUT)
        self._heard = RegionWriter(fds["io_in"], "io_in", SAID_LAYOUT)
        self._written = b""
        self._count = len(cell.io)
        self._payload: bytes | None = None
        self._of_services: list[Said] = []

    def turn(self, state: CellState, rc_outputs: bytes | bytearray, services_ns: Ns, now: Ns) -> None:
        """`services_ns`: stamp of the services' last beat."""
        payload = self._said.read()
        if payload is not None and payload is not self._payload:
            self._payload, self._of_services = payload, unpack_said(payload)
        shown = self._outputs.show(state, rc_outputs, self._of_services if now - services_ns < SERVICES_GONE else [])
        heard = [Said()] * self._count
        for family in self._families:
            family.show(shown)
            for number, what in family.said().items():
                heard[number] = what
        octets = pack_said(heard)
        if octets != self._written:
            self._written = octets
            self._heard.write(octets, now)


class InputMarks:
    """Validity of each RC output byte: one from an I/O block is bad while its module is silent (AX-399)."""

    def __init__(self, families: Sequence[RhoFamily], fd: int) -> None:
        self._buses = [family.io for family in families if family.io is not None]
        self._region = RegionWriter(fd, "marks", MARKS_LAYOUT)
        self._bad: list[int] | None = None

    def turn(self, now: Ns) -> None:
        """Once per cycle, before it beats."""
        bad = [byte for bus in self._buses for byte in bus.untrusted()]
        if bad != self._bad:
            self._bad, marks = bad, bytearray([Quality.GOOD] * RC_BYTES)
            for byte in bad:
                marks[byte] = Quality.BAD
            self._region.write(marks, now)


class IoErrors:
    """Runtime errors of I/O blocks and parameter downloads to the services: the cell's errors 380, 381, 645, 650 (AX-431)."""

    def __init__(self, families: Sequence[RhoFamily], fd: int) -> None:
        self._ledger = Ledger()
        for family in families:
            family.ledger = self._ledger
        self._region = RegionWriter(fd, "io_errors", LEDGER_LAYOUT)

    def turn(self, now: Ns) -> None:
        """Once per cycle."""
        if self._ledger.changed:
            self._region.write(self._ledger.pack(), now)


def cycle_contacts(cell: Cell, families: Sequence[BusFamily], fds: Mapping[str, int], p5_ms: int) -> CycleContacts | None:
    """None: no bus of this cell has a coupler."""
    found = [family for family in families if isinstance(family, CouplerFamily)]
    return CycleContacts(cell, found, fds, p5_ms) if found else None
