"""One bus of CiA 402 drives: sends SYNC, RPDOs and the gateway's heartbeat, receives TPDOs, passes all other frames to the master.

Source: CiA 301, predefined connection set; AX-302 (maps), AX-303 (heartbeat).

    RPDO1 200h+n  6040h controlword u16, 607Ah target i32     every SYNC, to nodes the master released
    RPDO2 300h+n  6060h mode i8                               while 6061h differs from the wanted mode
    TPDO1 180h+n  6041h statusword u16, 6064h position i32    every SYNC
    TPDO2 280h+n  6077h torque i16, 60F4h lag i32             every SYNC if the bus has room, otherwise not mapped
    TPDO3 380h+n  60FDh inputs u32, 6061h mode i8             on change

Drives whose touch probe measures (AX-569) have 60B9h status u16 as the last entry of TPDO3, and

    RPDO3 400h+n  60B8h touch probe function u16              to arm it anew after an edge
    TPDO4 480h+n  60BAh, 60BBh i32 (probe 2: 60BCh, 60BDh)    on change

A node gets cyclic data only between `release` (the master has configured it) and its next boot-up message or `hold`.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drivers.drives.cia402 import Cia402Actual, Cia402Set
from drivers.drives.cia402_states import Command
from drivers.drives.family import Heard, Latched, SetRecord
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen.nmt import State, heartbeat

SYNC = Frame(cobid.SYNC)
GATEWAY_NODE = 127  # produces the heartbeat the drives watch
BOOT_UP = bytes((State.INITIALISING,))
TPDO2, TPDO3, TPDO4 = cobid.tpdo(2, 0), cobid.tpdo(3, 0), cobid.tpdo(4, 0)
NO_PROBES: Mapping[int, int] = {}
STOP_CYCLES = 10  # cycles of quick stop to a node that seems lost: it may still receive
MODE_EVERY = 8  # cycles between two RPDO2 of a node that does not show the wanted mode yet

_SET, _MODE = struct.Struct("<Hi"), struct.Struct("<b")
_STATUS, _TORQUE, _INPUTS = struct.Struct("<Hi"), struct.Struct("<hi"), struct.Struct("<Ib")
_PROBED, _PLACES, _WORD = struct.Struct("<IbH"), struct.Struct("<ii"), struct.Struct("<H")
PROBE_ON = 0x31  # 60B8h of probe 1: enabled, first event, its own input, both edges
ARMED, RISEN, FALLEN = 1, 2, 4  # 60B9h
TAKEN = RISEN | FALLEN
PLACES_WITHIN = 2  # cycles by which the positions of an edge may follow its status


@dataclass(slots=True)
class _Node:
    index: int  # of the axis in the cell
    number: int
    released: bool = False
    torque: int = 0
    lag: int = 0
    inputs: int = 0
    mode: int = 0
    error: int = 0
    wait: int = 0  # cycles until RPDO2 may be sent again
    stopping: int = 0  # cycles in which it is still ordered to stop, though it counts as lost
    place: int = 0  # its last 6064h
    probe: int = 0  # touch probe that measures: 1, 2; 0: none
    status: int = -1  # its byte of 60B9h, -1: not received yet
    places: tuple[int, int] = (0, 0)  # of its last rising and falling edge
    edges: int = 0  # of its status, not reported yet
    settling: int = 0
    arm: int = -1  # 60B8h sent last
    wait_arm: int = 0
    latched: Latched = Latched()
    set_id: int = field(init=False)
    mode_id: int = field(init=False)

    def __post_init__(self) -> None:
        self.set_id, self.mode_id = cobid.rpdo(1, self.number), cobid.rpdo(2, self.number)


class Cia402Family:
    """Nodes of one bus; `axes`: (index in the cell, node)."""

    def __init__(
        self, axes: Sequence[tuple[int, int]], heartbeat_cycles: int, quiet_cycles: int, probes: Mapping[int, int] = NO_PROBES
    ) -> None:
        """The heartbeat leaves every `heartbeat_cycles`, first after `quiet_cycles`: by then a predecessor's death was noticed.  probes:
        nodes whose touch probe (1, 2) measures."""
        self.aside: list[Frame] = []
        self._nodes = {number: _Node(index, number, probe=probes.get(number, 0)) for index, number in axes}
        self._heartbeat_cycles, self._beat = max(1, heartbeat_cycles), max(1, quiet_cycles)
        self._heartbeat = heartbeat(GATEWAY_NODE, State.OPERATIONAL)
        self._status = {cobid.tpdo(1, number): node for number, node in self._nodes.items()}
        self._others = {TPDO2 + number: node for number, node in self._nodes.items()}
        self._others |= {TPDO3 + number: node for number, node in self._nodes.items()}
        self._others |= {TPDO4 + number: node for number, node in self._nodes.items() if number in probes}

    @property
    def expected(self) -> int:
        """Released nodes answer every SYNC."""
        return sum(node.released for node in self._nodes.values())

    @property
    def unconfigured(self) -> int:
        """Nodes the master has not started up, or not again."""
        return len(self._nodes) - self.expected

    def release(self, node: int, mode: int) -> None:
        """Configured and operational, in this mode."""
        found = self._nodes.get(node)
        if found is not None:
            found.released, found.mode, found.error, found.stopping = True, mode, 0, 0

    def answers(self, node: int, mode: int) -> None:
        """On a bus with another master: a node that answers SYNC was configured by that master, in this mode unless it reports another."""
        found = self._nodes.get(node)
        if found is not None and not found.released:
            self.release(node, found.mode or mode)

    def hold(self, node: int) -> None:
        """Send no RPDO until it is configured again."""
        found = self._nodes.get(node)
        if found is not None:
            _let_go(found)

    def began(self, now: Ns) -> None:
        """Nothing depends on it here."""

    def burst(self, values: Sequence[SetRecord]) -> list[Frame]:
        """SYNC, RPDOs of released nodes, the heartbeat when it is due; TypeError when a drive of another family was put here."""
        frames, modes = [SYNC], []
        for node in self._nodes.values():
            if not node.released:
                if node.stopping:
                    node.stopping -= 1
                    frames.append(Frame(node.set_id, _SET.pack(Command.QUICK_STOP.value, node.place)))
                continue
            value = values[node.index]
            if not isinstance(value, Cia402Set):
                raise TypeError(f"axis {node.index + 1}: {type(value).__name__} on a CANopen bus")
            frames.append(Frame(node.set_id, _SET.pack(value.controlword & 0xFFFF, value.position_inc)))
            if value.mode != node.mode:
                modes += self._mode(node, value.mode)
            else:
                node.wait = 0
            if node.probe:
                modes += _arming(node)
        frames += modes
        self._beat -= 1
        if self._beat <= 0:
            self._beat = self._heartbeat_cycles
            frames.append(self._heartbeat)
        return frames

    def _mode(self, node: _Node, mode: int) -> list[Frame]:
        node.wait -= 1
        if node.wait > 0:
            return []
        node.wait = MODE_EVERY
        return [Frame(node.mode_id, _MODE.pack(mode))]

    def hear(self, frame: Frame) -> Heard | None:
        """The actual value of an axis; None: handled or put aside; raises DecodeError for a frame that no drive or master of this bus
        sends.
        """
        identifier, data = frame.identifier, frame.data
        node = self._status.get(identifier)
        if node is not None:
            if len(data) != 6:
                raise DecodeError(f"TPDO1 of node {node.number}: 6 bytes expected, {data.hex(' ')}")
            status, position = _STATUS.unpack(data)
            node.place = position
            if not node.released:
                return None
            if node.edges:
                _settle(node)
            actual = Cia402Actual(
                status, position, node.torque, node.lag, node.inputs, node.mode, node.error, node.latched if node.probe else None
            )
            return Heard(node.index, actual)
        node = self._others.get(identifier)
        if node is not None:
            _take(node, identifier, data)
        else:
            self._put_aside(frame)
        return None

    def _put_aside(self, frame: Frame) -> None:
        function, number = frame.identifier & 0x780, frame.identifier & 0x7F
        node = self._nodes.get(number)
        if function == cobid.emcy(0) and number:
            if node is not None and len(frame.data) == 8:
                node.error = int.from_bytes(frame.data[:2], "little")
        elif function == cobid.heartbeat(0) and number:
            if node is not None and frame.data == BOOT_UP:
                _let_go(node)  # boot-up: its configuration may be lost, or another master reset it
                node.status, node.edges = -1, 0
        elif function != cobid.sdo_answer(0) and frame.identifier != cobid.LSS_SLAVE:
            raise DecodeError(f"no node of this bus uses identifier {frame.identifier:#x}: {frame.data.hex(' ')}")
        self.aside.append(frame)


def _let_go(node: _Node) -> None:
    """Stop its set values; a drive that is enabled and still receives brakes."""
    if node.released:
        node.released, node.stopping = False, STOP_CYCLES


def _take(node: _Node, identifier: int, data: bytes) -> None:
    if identifier == TPDO2 + node.number:
        if len(data) != _TORQUE.size:
            raise DecodeError(f"TPDO2 of node {node.number}: {_TORQUE.size} bytes expected, {data.hex(' ')}")
        node.torque, node.lag = _TORQUE.unpack(data)
    elif identifier == TPDO4 + node.number:
        if len(data) != _PLACES.size:
            raise DecodeError(f"TPDO4 of node {node.number}: {_PLACES.size} bytes expected, {data.hex(' ')}")
        node.places = _PLACES.unpack(data)
    elif node.probe:
        if len(data) != _PROBED.size:
            raise DecodeError(f"TPDO3 of node {node.number}: {_PROBED.size} bytes expected, {data.hex(' ')}")
        node.inputs, node.mode, status = _PROBED.unpack(data)
        _shown(node, status)
    else:
        if len(data) != _INPUTS.size:
            raise DecodeError(f"TPDO3 of node {node.number}: {_INPUTS.size} bytes expected, {data.hex(' ')}")
        node.inputs, node.mode = _INPUTS.unpack(data)


def _shown(node: _Node, status: int) -> None:
    """Evaluate 60B9h: an edge is a bit that was 0 before; the first telegram only sets the initial state."""
    byte = status >> 8 * (node.probe - 1) & 0xFF
    new = byte & TAKEN & ~node.status if node.status >= 0 else 0
    node.status = byte
    if new:
        node.edges, node.settling = node.edges | new, PLACES_WITHIN


def _settle(node: _Node) -> None:
    """Positions may arrive after the status: report an edge when both are here."""
    node.settling -= 1
    if node.settling > 0:
        return
    before, (rising, falling) = node.latched, node.places
    rises, falls = before.rises + bool(node.edges & RISEN), before.falls + bool(node.edges & FALLEN)
    node.latched, node.edges = Latched(rises, rising, falls, falling), 0


def _arming(node: _Node) -> list[Frame]:
    """Switched off and on again after every edge, so that the next one is seen even at the same place."""
    if node.status < 0 or node.edges or node.status & (TAKEN | ARMED) == ARMED:
        node.arm = -1
        return []
    wanted = 0 if node.status & TAKEN else PROBE_ON << 8 * (node.probe - 1)
    node.wait_arm = 0 if wanted != node.arm else node.wait_arm - 1
    if node.wait_arm > 0:
        return []
    node.arm, node.wait_arm = wanted, MODE_EVERY
    return [Frame(cobid.rpdo(3, node.number), _WORD.pack(wanted))]
