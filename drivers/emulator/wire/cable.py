"""Wire model: transmission of frames on a CAN cable, bit by bit in virtual time.

Arbitration by identifier, stuffing, error frames, error counters, error passive, bus-off and recovery.
Source: ISO 11898-1:2015, 10.4 (frames), 10.8 (arbitration), 10.11 (errors), 12.1.4 (fault confinement, rules a to h); figures: can.md C4.
Pure: accepts stamped offers, returns stamped events; equal offers produce an equal bus, bit for bit.  Each node sends its own frames in the
order they were offered, like a SocketCAN interface (AX-330).
"""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

from protocols.base.can_bits import BASE_HEAD, TAIL, frame_bits
from protocols.base.machine import Frame, Ns

INTERFRAME = 3
ERROR_FLAG, ERROR_ECHO, ERROR_DELIMITER = 6, 6, 8  # echo: flags of the others, answering the stuff error of the first flag
SUSPEND = 8  # bits an error passive transmitter waits more than the others
PASSIVE, BUS_OFF = 128, 256  # of an error counter
RECOVERY_BITS = 128 * 11  # recessive bits a node must see before it leaves bus-off
ACK_SLOT = TAIL - INTERFRAME - 7 - 2  # bits of the tail before the acknowledge slot ends

NO_ACK, TWINS = "no ACK", "two nodes send this identifier"


class NodeState(Enum):
    """Fault confinement of one node."""

    ERROR_ACTIVE = auto()
    ERROR_PASSIVE = auto()
    BUS_OFF = auto()


@dataclass(frozen=True, slots=True)
class Carried:
    """A frame all attached nodes have, at the end of its EOF; the frame's stamp is `end_ns`."""

    frame: Frame
    node: int
    start_ns: Ns
    end_ns: Ns


@dataclass(frozen=True, slots=True)
class Destroyed:
    """A frame that ended in an error frame; the controller repeats it."""

    frame: Frame
    node: int
    why: str
    end_ns: Ns


@dataclass(frozen=True, slots=True)
class StateChanged:
    """A node's fault confinement changed."""

    node: int
    state: NodeState
    at_ns: Ns


Event = Carried | Destroyed | StateChanged


@dataclass(slots=True)
class Node:
    """One controller on the wire."""

    name: str
    queue: deque[tuple[Ns, Frame]] = field(default_factory=deque)
    tec: int = 0  # transmit error counter
    rec: int = 0  # receive error counter
    state: NodeState = NodeState.ERROR_ACTIVE
    plugged: bool = True
    free_ns: Ns = 0  # not before: suspended after its own frame, or recovering
    recovering: bool = False


@dataclass(slots=True)
class Load:
    """Load of the wire since it was created."""

    frames: int = 0
    bits: int = 0  # of frames that went through, stuffing and interframe space included
    errors: int = 0
    error_bits: int = 0  # of frames that were destroyed, with their error frames
    busy_ns: Ns = 0
    longest_wait_ns: Ns = 0  # from the offer to the start bit


@dataclass(frozen=True, slots=True)
class _Attempt:
    """The next frame on the wire, or the next collision."""

    start: Ns
    end: Ns  # of EOF, or of the error frame
    winners: tuple[int, ...]
    frame: Frame
    bits: int
    why: str  # empty: it gets through


class Wire:
    """One cable.  `offer` frames with the time at which the controller got them, `advance` to get the events until then."""

    def __init__(self, bitrate: int = 1_000_000) -> None:
        """bitrate: bit/s; ValueError if a bit is not a whole number of nanoseconds."""
        if bitrate <= 0 or 1_000_000_000 % bitrate:
            raise ValueError(f"bit rate {bitrate} bit/s: one bit must be a whole number of nanoseconds")
        self.bit_ns: Ns = 1_000_000_000 // bitrate
        self.nodes: list[Node] = []
        self.load = Load()
        self._idle_ns: Ns = 0  # the wire is free from here
        self._cut_ns: list[Ns] = []  # per node: when its cable was last cut or mended
        self._hits: deque[tuple[int | None, str]] = deque()  # (node or any, why): the next frames of it are destroyed

    # ---- who hangs on it ---------------------------------------------------------------------------------------------
    def attach(self, name: str) -> int:
        """A new node; its number."""
        self.nodes.append(Node(name))
        self._cut_ns.append(0)
        return len(self.nodes) - 1

    def plug(self, node: int, now: Ns, *, plugged: bool = True) -> None:
        """Cut or mend the cable at this node: unplugged it receives nothing, acknowledges nothing, and its frames end without an ACK."""
        self.nodes[node].plugged = plugged
        self._cut_ns[node] = now

    def restart(self, node: int, now: Ns) -> None:
        """The host restarts a bus-off controller: it is back after 128 x 11 recessive bits (rule h)."""
        one = self.nodes[node]
        if one.state is NodeState.BUS_OFF and not one.recovering:
            one.recovering, one.free_ns = True, now + RECOVERY_BITS * self.bit_ns

    def spoil(self, count: int = 1, node: int | None = None, why: str = "bit error") -> None:
        """The next `count` frames (of that node) are destroyed at their last CRC bit."""
        self._hits.extend([(node, why)] * count)

    # ---- frames ------------------------------------------------------------------------------------------------------
    def offer(self, node: int, frame: Frame, now: Ns) -> bool:
        """Hand a frame to the node's controller; False when it is bus-off and accepts nothing."""
        one = self.nodes[node]
        if one.state is NodeState.BUS_OFF:
            return False
        one.queue.append((now, frame))
        return True

    def backlog_ns(self, now: Ns) -> Ns:
        """How long the wire needs for everything that waits now: more than a cycle means that the bus is full."""
        waiting = sum(frame_bits(f.identifier, f.data) for n in self.nodes if n.plugged for _, f in n.queue)
        return max(0, self._idle_ns - now) + waiting * self.bit_ns

    def next_end(self) -> Ns | None:
        """When the next frame (or its error frame) will be over if nothing else is offered; None: nothing waits."""
        attempt = self._next_attempt()
        return attempt.end if attempt else None

    def advance(self, until: Ns) -> list[Event]:
        """Everything that ended by `until`, in order; all offers up to then must have been made."""
        events: list[Event] = []
        while True:
            self._recover(until, events)
            attempt = self._next_attempt()
            if attempt is None or attempt.end > until:
                self._shout_alone(until, events)
                return events
            self._idle_ns = attempt.end + INTERFRAME * self.bit_ns
            self.load.longest_wait_ns = max(self.load.longest_wait_ns, attempt.start - self.nodes[attempt.winners[0]].queue[0][0])
            self.load.busy_ns += self._idle_ns - attempt.start
            if attempt.why:
                self._destroy(attempt, events)
            else:
                self._carry(attempt, events)

    def _head(self, node: int) -> Frame:
        return self.nodes[node].queue[0][1]

    def _next_attempt(self) -> "_Attempt | None":
        """The lowest identifier of all that are ready when the wire is free, and how it will end."""
        ready = [
            (max(one.queue[0][0], one.free_ns, self._idle_ns), number)
            for number, one in enumerate(self.nodes)
            if one.queue and one.plugged and one.state is not NodeState.BUS_OFF
        ]
        if not ready:
            return None
        start = min(at for at, _ in ready)
        rivals = [number for at, number in ready if at == start]
        lowest = min(self._head(number).identifier for number in rivals)
        winners = tuple(number for number in rivals if self._head(number).identifier == lowest)
        frame = self._head(winners[0])
        bits, why = frame_bits(frame.identifier, frame.data), self._fate(winners, frame)
        heard = bits - INTERFRAME if not why else self._heard(bits, why)
        return _Attempt(start, start + heard * self.bit_ns, winners, frame, bits, why)

    def _fate(self, winners: tuple[int, ...], frame: Frame) -> str:
        """Why this frame will not get through; empty: it will."""
        if any(self._head(other).data != frame.data for other in winners[1:]):
            return TWINS
        if self._hits and self._hits[0][0] in (None, winners[0]):
            return self._hits[0][1]
        listeners = [n for k, n in enumerate(self.nodes) if k not in winners and n.plugged and n.state is not NodeState.BUS_OFF]
        return "" if listeners or len(winners) > 1 else NO_ACK

    @staticmethod
    def _heard(bits: int, why: str) -> int:
        """Bits up to the end of the error frame: the bits sent, flag, the others' flags, delimiter."""
        if why == NO_ACK:
            return bits - TAIL + ACK_SLOT + ERROR_FLAG + ERROR_DELIMITER
        sent = BASE_HEAD + 1 if why == TWINS else bits - TAIL  # twins differ at the earliest just after the DLC
        return sent + ERROR_FLAG + ERROR_ECHO + ERROR_DELIMITER

    def _carry(self, attempt: "_Attempt", events: list[Event]) -> None:
        self.load.frames += 1
        self.load.bits += attempt.bits
        for number in attempt.winners:  # the same frame from two nodes at once is one frame on the wire
            self.nodes[number].queue.popleft()
        frame = Frame(attempt.frame.identifier, attempt.frame.data, attempt.end)
        events.append(Carried(frame, attempt.winners[0], attempt.start, attempt.end))
        for number, one in enumerate(self.nodes):
            if number in attempt.winners:
                one.tec = max(0, one.tec - 1)
                self._suspend(one)
            elif one.plugged and one.rec:
                one.rec = min(one.rec, PASSIVE) - 1
            self._confine(number, attempt.end, events)

    def _destroy(self, attempt: "_Attempt", events: list[Event]) -> None:
        """Counters of an error frame; the frame stays at the head of its queue and all try again."""
        alone = attempt.why == NO_ACK
        if self._hits and attempt.why == self._hits[0][1]:
            self._hits.popleft()
        self.load.errors += 1
        self.load.error_bits += (self._idle_ns - attempt.start) // self.bit_ns
        for number, one in enumerate(self.nodes):
            if number in attempt.winners:
                events.append(Destroyed(one.queue[0][1], number, attempt.why, attempt.end))
                if not (alone and one.state is NodeState.ERROR_PASSIVE):  # rule c, exception 1: a missing partner is no reason for bus-off
                    one.tec += 8
                self._suspend(one)
            elif one.plugged and not alone and one.state is not NodeState.BUS_OFF:
                one.rec += 1
            self._confine(number, attempt.end, events)

    def _suspend(self, one: Node) -> None:
        if one.state is NodeState.ERROR_PASSIVE:
            one.free_ns = self._idle_ns + SUSPEND * self.bit_ns

    def _shout_alone(self, until: Ns, events: list[Event]) -> None:
        """Nodes on a cut cable: no ACK until they are error passive; from there nothing changes."""
        for number, one in enumerate(self.nodes):
            if one.plugged or not one.queue or one.state is not NodeState.ERROR_ACTIVE:
                continue
            offered, frame = one.queue[0]
            failed = self._heard(frame_bits(frame.identifier, frame.data), NO_ACK) + INTERFRAME
            attempts = -(-(PASSIVE - one.tec) // 8)
            end = max(offered, self._cut_ns[number]) + attempts * failed * self.bit_ns
            if end <= until:
                one.tec += 8 * attempts
                events.append(Destroyed(frame, number, NO_ACK, end))
                self._confine(number, end, events)

    def _confine(self, number: int, now: Ns, events: list[Event]) -> None:
        one = self.nodes[number]
        state = NodeState.BUS_OFF if one.state is NodeState.BUS_OFF or one.tec >= BUS_OFF else NodeState.ERROR_ACTIVE
        if state is NodeState.ERROR_ACTIVE and (one.tec >= PASSIVE or one.rec >= PASSIVE):
            state = NodeState.ERROR_PASSIVE
        if state is not one.state:
            one.state = state
            events.append(StateChanged(number, state, now))
            if state is NodeState.BUS_OFF:
                one.queue.clear()

    def _recover(self, until: Ns, events: list[Event]) -> None:
        for number, one in enumerate(self.nodes):
            if one.recovering and one.free_ns <= until:
                one.recovering, one.tec, one.rec, one.state = False, 0, 0, NodeState.ERROR_ACTIVE
                events.append(StateChanged(number, one.state, one.free_ns))
