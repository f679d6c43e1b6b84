"""CiA 401 couplers on the drives' CANopen bus: RPDO1 out of the completed cycle, TPDO1 and their heartbeats in (AX-401).

Source: CiA 401, default PDO 1: up to 64 digital outputs (6200h) in RPDO1 200h+n, up to 64 digital inputs (6000h) in TPDO1 180h+n, channel
0 is bit 0 of byte 0.  A coupler is addressed between its release by the master and its next boot-up message, like a drive.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drivers.drives.family import BusFamily, Heard, SetRecord
from drivers.drives.io_boot import INPUTS_ONLY
from gateway.pure.buses.contacts import Said
from gateway.pure.image.fast_inputs import InputLevel
from gateway.pure.image.records.cell import Quality
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen.nmt import State

REFRESH = 25  # cycles after which outputs are sent again though nothing has changed: a lost frame is made good
BOOT_UP = bytes((State.INITIALISING,))


@dataclass(slots=True)
class Coupler:
    """One node; channel -> number of the contact among the [[io]] tables."""

    node: int
    outputs: Mapping[int, int] = field(default_factory=dict)
    inputs: Mapping[int, int] = field(default_factory=dict)
    vital_inputs: bool = False  # an enabling input hangs on it
    vital_outputs: bool = False  # a watchdog, a brake or what signals readiness does
    mapped: int = 0  # bytes of RPDO1 as the master found them
    inputs_only: bool = False  # it refused what its outputs need
    released: bool = False
    heard: bytes = b""  # last TPDO1 since the release
    changed_ns: Ns = 0  # bus stamp of the first one with this value
    silent: int = 0  # cycles since anything came from it
    sent: bytes = b""
    due: int = 0  # cycles until the next refresh

    @property
    def size(self) -> int:
        """Bytes of RPDO1; 0: the cell uses no output, or the coupler refused what they need."""
        return max(self.mapped, max(self.outputs) // 8 + 1) if self.outputs and not self.inputs_only else 0


class CouplerFamily:
    """A BusFamily around the family of the drives on that bus.  `show` once per completed cycle, before the burst."""

    def __init__(self, drives: BusFamily, couplers: Sequence[Coupler], patience: int) -> None:
        """`patience`: cycles a coupler may be silent before its inputs are bad."""
        self.drives = drives
        self.aside = drives.aside
        self.couplers = {coupler.node: coupler for coupler in couplers}
        self._patience = patience
        self._inputs = {cobid.tpdo(1, node): coupler for node, coupler in self.couplers.items()}
        self._shown: dict[int, bool] = {}

    @property
    def expected(self) -> int:
        """Couplers are not waited for: they speak when something changes."""
        return self.drives.expected

    @property
    def unconfigured(self) -> int:
        """Couplers have no place in a burst of their own."""
        return self.drives.unconfigured

    @property
    def shown(self) -> Mapping[int, bool]:
        """What the outputs show, by contact."""
        return self._shown

    def show(self, contacts: Mapping[int, bool]) -> None:
        """What the outputs show from the next burst on."""
        self._shown.update(contacts)

    def said(self) -> dict[int, Said]:
        """Return the state of the inputs, by contact; outputs are valid while their node accepts them."""
        found: dict[int, Said] = {}
        for coupler in self.couplers.values():
            alive = self._alive(coupler)
            for channel, contact in coupler.inputs.items():
                octet = channel // 8
                known = octet < len(coupler.heard)
                value = known and bool(coupler.heard[octet] >> channel % 8 & 1)
                found[contact] = Said(value, Quality.GOOD if alive and known else Quality.BAD)
            for contact in coupler.outputs.values():
                good = alive and not coupler.inputs_only
                found[contact] = Said(self._shown.get(contact, False), Quality.GOOD if good else Quality.BAD)
        return found

    @property
    def lost(self) -> bool:
        """Return whether a coupler required for readiness is missing or does not accept its outputs."""
        for coupler in self.couplers.values():
            if coupler.vital_outputs and (coupler.inputs_only or not self._alive(coupler)):
                return True
            if coupler.vital_inputs and not self._alive(coupler):
                return True
        return False

    def input_at(self, node: int, channel: int) -> InputLevel | None:
        """Present state of one input; None while it is not good."""
        coupler = self.couplers[node]
        octet = channel // 8
        if not self._alive(coupler) or octet >= len(coupler.heard):
            return None
        return InputLevel(bool(coupler.heard[octet] >> channel % 8 & 1), coupler.changed_ns)

    def _alive(self, coupler: Coupler) -> bool:
        return coupler.released and coupler.silent <= self._patience

    def burst(self, values: Sequence[SetRecord]) -> list[Frame]:
        """The drives' burst, then RPDO1 of each coupler that has news or whose refresh is due."""
        frames = self.drives.burst(values)
        for coupler in self.couplers.values():
            coupler.silent += 1
            coupler.due -= 1
            if not coupler.released or not coupler.size:
                continue
            data = self._octets(coupler)
            if data != coupler.sent or coupler.due <= 0:
                coupler.sent, coupler.due = data, REFRESH
                frames.append(Frame(cobid.rpdo(1, coupler.node), data))
        return frames

    def _octets(self, coupler: Coupler) -> bytes:
        octets = bytearray(coupler.size)
        for channel, contact in coupler.outputs.items():
            octets[channel // 8] |= self._shown.get(contact, False) << channel % 8
        return bytes(octets)

    def hear(self, frame: Frame) -> Heard | None:
        """TPDO1 and heartbeats of couplers are taken here; raises DecodeError as the drives' family does."""
        coupler = self._inputs.get(frame.identifier)
        if coupler is not None:
            coupler.silent = 0
            if coupler.released and frame.data != coupler.heard:
                coupler.heard, coupler.changed_ns = frame.data, frame.stamp_ns
            return None
        node = self.couplers.get(frame.identifier & 0x7F)
        if node is not None and frame.identifier == cobid.heartbeat(node.node):
            node.silent = 0
            if frame.data == BOOT_UP:
                self.hold(node.node)
        return self.drives.hear(frame)

    def release(self, node: int, mode: int) -> None:
        """Release a configured, operational coupler; its inputs are valid from now on."""
        coupler = self.couplers.get(node)
        if coupler is None:
            self.drives.release(node, mode)
        else:
            coupler.inputs_only = mode & 0xFF == INPUTS_ONLY
            coupler.mapped = 0 if coupler.inputs_only else mode
            coupler.released, coupler.sent, coupler.silent, coupler.due = True, b"", 0, 0

    def hold(self, node: int) -> None:
        """Nothing any more until it is configured again."""
        coupler = self.couplers.get(node)
        if coupler is None:
            self.drives.hold(node)
        else:
            coupler.released, coupler.heard, coupler.sent = False, b"", b""

    def began(self, now: Ns) -> None:
        self.drives.began(now)


def contacts_lost(families: Sequence[BusFamily]) -> bool:
    """On any bus."""
    return any(family.lost for family in families if isinstance(family, CouplerFamily))
