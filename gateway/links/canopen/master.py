"""The master of a CANopen bus: starts the nodes up, supervises them, reports their faults.  Runs in threads of the services.

The settings of each node are the pure plan of drivers.drives.cia402_boot; the `canopen` package carries it out over the python-can plug-in
`cycle:`.  Each node has its own lock for SDO; a node that does not answer is tried again after 1, 2, 5 s and never delays another one
(AX-309).
"""

import contextlib
import functools
import logging
import threading
import time
import traceback
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeVar

import can
import canopen
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError, SdoError

from drivers.drives import canopen_steps as steps
from drivers.drives import cia402_boot as plans
from drivers.drives import io_boot
from drivers.drives.canopen_steps import Answer, Refused, Silent
from drivers.drives.cia402_boot import Booted, BootRefused, NodePlan
from drivers.drives.io_boot import CouplerPlan
from drivers.ports.can import cycle_bus
from gateway.files.eds import canopen_dictionary
from gateway.links.canopen.sdo_client import bounded_upload
from protocols.base.errors import ProtocolError
from protocols.canopen import cob_id as cobid
from protocols.canopen import emcy
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.nmt import State

TICK_S = 0.02
SDO_S = 0.3  # patience with one answer, from when the request has left at the latest
IN_LINE = 2  # frames of each node that may precede a request: its own request, and the end of one that was not answered
SDO_TRIES = 3
BOOT_UP_S = 2.0  # patience with a boot-up message or a state of the heartbeat
WAITS_S = (1.0, 2.0, 5.0)  # before the next attempt with a node that does not answer
REFUSED_S = 10.0  # before the next attempt with one that was refused
REPORT_S = 1.0  # at most one emergency message of a node is reported in this time
ANSWERS, SDO_BYTES = 256, 8  # of a node that may wait unread, more than a block transfer has (127); bytes of one
LATE = 2  # heartbeats more than the drive's own patience with us before the node counts as lost

logging.getLogger("canopen").setLevel(logging.CRITICAL)  # failures are reported here, with an explanation


class Health(Enum):
    """State of a node."""

    WAITING = "waiting for its start-up"
    BOOTING = "is started up"
    READY = "ready"
    DEAD = "does not answer"
    REFUSED = "is not started"


@dataclass
class Node:
    """One node and its state."""

    plan: NodePlan
    name: str  # of the axis
    health: Health = Health.WAITING
    why: str = ""
    due: float = 0.0  # next attempt
    attempts: int = 0
    seen: float = 0.0  # last heartbeat
    state: int = -1  # as reported by the node
    boots: int = 0  # boot-up messages received
    booted: Booted | None = None
    emergency: int = 0  # code of the last EMCY, 0: none or gone
    emergencies: int = 0
    unreported: int = 0  # of them not reported one by one
    quiet_until: float = 0.0
    adopted: bool = False  # the next attempt only looks: a predecessor has configured it
    asked: int = 0  # number of requests to start it up again
    lock: threading.Lock = field(default_factory=threading.Lock)  # one SDO dialogue at a time
    news: threading.Event = field(default_factory=threading.Event)  # a heartbeat came
    thread: threading.Thread | None = None


class MasterLink(cycle_bus.CycleLink, Protocol):
    """The bus as the master needs it: through the cycle's ring, or a port of a tool's own."""

    def release(self, node: int, mode: int) -> None: ...  # this node is configured
    def hold(self, node: int) -> None: ...  # no longer configured
    def left_out(self, identifier: int) -> int: ...  # frames of a storm that receive() has not passed on since the last call


class Receiving(can.Listener):
    """Keeps the receiving thread alive: one frame or one look at the ring that fails is reported, and the next one is received.

    Without it python-can ends the thread, and canopen raises that one error in every dialogue from then on.
    """

    def __init__(self, network: canopen.Network, report: Callable[[str], None]) -> None:
        self._network, self._report = network, report

    def on_message_received(self, msg: can.Message) -> None:
        """Called by canopen as its listener."""

    def on_error(self, exc: Exception) -> None:
        if self._network.notifier is not None:
            self._network.notifier.exception = None
        self._report(f"receiving failed and continues: {place_of(exc)}")
        time.sleep(TICK_S)  # an error that persists must not become a busy loop

    def stop(self) -> None:
        """Nothing is open."""


def place_of(error: BaseException) -> str:
    """Kind, words and the innermost line."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({frames[-1].filename.rpartition('/')[2]}:{frames[-1].lineno} in {frames[-1].name})" if frames else ""
    return f"{type(error).__name__}: {error}{place}"


class EndedError(Exception):
    """A dialogue was aborted between two of its steps; the message names the reason."""


T = TypeVar("T")
Say = Callable[[str, str, Mapping[str, object]], None]  # kind, sentence, facts


def start_up(plan: NodePlan, *, adopting: bool) -> plans.Plan:
    """The plan of a drive or of an I/O coupler."""
    if isinstance(plan, CouplerPlan):
        return io_boot.adopt(plan) if adopting else io_boot.boot(plan)
    return plans.adopt(plan) if adopting else plans.boot(plan)


class CanopenMaster:
    """All nodes of one bus."""

    def __init__(
        self,
        channel: str,
        link: MasterLink,
        nodes: Sequence[tuple[str, NodePlan]],
        say: Say,
        sheets: Mapping[int, ObjectDictionary] | None = None,
        language: str = "en",
        cycle_s: float = 0.0,
    ) -> None:
        """`nodes`: (axis, plan); `sheets`: their EDS by node; `cycle_s`: interval of the frames that the link sends."""
        self._language = language
        self.nodes = {plan.node: Node(plan, name) for name, plan in nodes}
        self._channel, self._link, self._say = channel, link, say
        self._sheets = sheets or {}
        self._in_line_s = IN_LINE * len(nodes) * cycle_s
        self._stop = threading.Event()
        self._quiet_until = 0.0
        self._network: canopen.Network | None = None
        self._remote: dict[int, canopen.RemoteNode] = {}
        self._keeper = threading.Thread(target=self._keep, name=f"canopen {channel}", daemon=True)
        cycle_bus.attach(channel, link)

    # ---- life --------------------------------------------------------------------------------------------------------
    def start(self, adopted: Sequence[int] = ()) -> None:
        """`adopted`: nodes the cycle already uses; they are read, not configured."""
        for number in adopted:
            self.nodes[number].adopted = True
        self._keeper.start()

    def _connect(self) -> None:
        """Connect in the keeper's thread: reading data sheets takes a while, and command sources do not wait for it."""
        self._network = canopen.Network(can.Bus(interface="cycle", channel=self._channel))
        self._network.NOTIFIER_CYCLE = 0.2
        self._network.connect()
        assert self._network.notifier is not None
        self._network.notifier.add_listener(Receiving(self._network, self._ring_failed))
        known: dict[int, canopen.ObjectDictionary] = {}  # nodes of one type share their data
        for number, node in self.nodes.items():
            sheet = self._sheets.get(number)
            if id(sheet) not in known:
                known[id(sheet)] = canopen_dictionary(sheet, number)
            remote = canopen.RemoteNode(number, known[id(sheet)])
            self._network.add_node(remote)
            remote.sdo.RESPONSE_TIMEOUT, remote.sdo.MAX_RETRIES = SDO_S + self._in_line_s, 1
            self._hear(self._network, node, remote)
            self._remote[number] = remote

    def _hear(self, network: canopen.Network, node: Node, remote: canopen.RemoteNode) -> None:
        """Own listeners in place of the package's: those keep every emergency message and answer for ever, and fail on a short frame."""
        number = node.plan.node
        for identifier in (cobid.emcy(number), cobid.heartbeat(number), cobid.sdo_answer(number)):
            network.unsubscribe(identifier)
        network.subscribe(cobid.emcy(number), functools.partial(self._on_emergency, node))
        network.subscribe(cobid.heartbeat(number), self._on_heartbeat)
        network.subscribe(cobid.sdo_answer(number), functools.partial(self._on_answer, remote))

    @staticmethod
    def _on_answer(remote: canopen.RemoteNode, identifier: int, data: bytearray, stamp: float) -> None:
        """Unexpected answers wait for the next request, which drops them; more of them than a block transfer has are dropped here."""
        if len(data) == SDO_BYTES and remote.sdo.responses.qsize() < ANSWERS:
            remote.sdo.on_response(identifier, data, stamp)

    def _ring_failed(self, words: str) -> None:
        """At most once a second."""
        now = time.monotonic()
        if now >= self._quiet_until:
            self._quiet_until = now + REPORT_S
            self._say("alarm", f"{self._channel}: {words}", {})

    def stop(self) -> None:
        """Ends all threads; nodes stay as they are."""
        self._stop.set()
        for node in self.nodes.values():
            node.news.set()
        self._keeper.join(2.0)
        if self._network is not None:
            with contextlib.suppress(can.CanError):
                self._network.disconnect()
        cycle_bus.detach(self._channel)

    def again(self, number: int | None = None) -> None:
        """Start up once more: a new cycle, or on request."""
        for node in self.nodes.values():
            if number in (None, node.plan.node):
                node.adopted, node.asked = False, node.asked + 1
                if node.health is not Health.BOOTING:
                    node.health, node.due, node.attempts = Health.WAITING, 0.0, 0

    def status(self) -> list[dict[str, object]]:
        """For tools and pages."""
        return [
            {
                "bus": self._channel, "node": number, "axis": node.name, "health": node.health.name, "why": node.why,
                "emergency": node.emergency, "emergencies": node.emergencies, "attempts": node.attempts, "boots": node.boots,
            }
            for number, node in self.nodes.items()
        ]  # fmt: skip

    # ---- frames of the bus
    def _on_heartbeat(self, identifier: int, data: bytearray, stamp: float) -> None:
        node = self.nodes.get(identifier & 0x7F)
        if node is None or not data:
            return
        node.seen, node.state = time.monotonic(), data[0] & 0x7F
        if node.state == State.INITIALISING:
            node.boots += 1
            if node.health is Health.READY:
                self._lost(node, "was reset: it sent its boot-up message")
            elif node.health in (Health.DEAD, Health.REFUSED):
                node.due = 0.0
        node.news.set()

    def _on_emergency(self, node: Node, identifier: int, data: bytearray, stamp: float) -> None:
        """In words; a storm of them is one line a second with their number."""
        left_out = self._link.left_out(identifier)
        node.emergencies += 1 + left_out
        node.unreported += left_out
        try:
            error = emcy.decode(bytes(data))
        except ProtocolError:
            node.unreported += 1  # too short for one: counted
            return
        before, node.emergency = node.emergency, error.code
        now = time.monotonic()
        if error.code == before or now < node.quiet_until:
            node.unreported += 1
            return
        from drivers.drives.cia402_words import sentence

        more = f" ({node.unreported} more emergency messages before)" if node.unreported else ""
        node.quiet_until, node.unreported = now + REPORT_S, 0
        facts = {"node": node.plan.node, "code": error.code, "register": error.register}
        self._say("drive", f"{node.name}: {sentence(error.code, self._language)}{more}", facts)

    # ---- the keeper ------------------------------------------------------------------------------------------------------
    def _keep(self) -> None:
        self._connect()
        while not self._stop.wait(TICK_S):
            now = time.monotonic()
            for node in self.nodes.values():
                if node.health is Health.READY:
                    patience = node.plan.heartbeat_ms / 1000.0 * (node.plan.missed + LATE)
                    if now - node.seen > max(patience, 0.25):
                        self._lost(node, "its heartbeat is missing")
                    elif node.state not in (State.OPERATIONAL, -1):
                        self._lost(node, f"left operational: its heartbeat reports {node.state}")
                elif node.health is not Health.BOOTING and now >= node.due:
                    node.health, node.attempts = Health.BOOTING, node.attempts + 1
                    node.thread = threading.Thread(target=self._boot, args=(node,), name=f"boot {node.name}", daemon=True)
                    node.thread.start()

    def _lost(self, node: Node, why: str) -> None:
        self._link.hold(node.plan.node)
        node.health, node.why, node.due, node.attempts = Health.WAITING, why, 0.0, 0
        self._say("drive", f"{node.name} (node {node.plan.node}): {why}", {"node": node.plan.node})

    def _boot(self, node: Node) -> None:
        """One attempt, in a thread of its own: a node that does not answer delays no other."""
        plan, adopting, asked = node.plan, node.adopted, node.asked
        try:
            with node.lock:
                boots = node.boots
                booted = self._carry(node, start_up(plan, adopting=adopting))
                if node.boots > boots + (not adopting) or node.asked != asked:
                    raise BootRefused("was reset during its start-up", dead=True)
        except BootRefused as refusal:
            self._failed(node, refusal)
        except Exception as error:  # a thread that died in silence would leave the node waiting for ever
            self._failed(node, BootRefused(place_of(error), dead=True))  # not a reply of the node: tried again soon
        else:
            node.seen = time.monotonic()
            fresh = booted.refused if booted.refused != node.why else ""
            node.booted, node.attempts, node.why = booted, 0, booted.refused
            if not adopting:
                self._link.release(plan.node, booted.mode)
            node.adopted, node.health = False, Health.READY
            notes = f" ({'; '.join(booted.notes)})" if booted.notes else ""
            self._say("drive", f"{node.name} (node {plan.node}): ready{notes}", {"node": plan.node, "options": booted.options})
            if fresh:
                self._say("alarm", f"{node.name} (node {plan.node}): {fresh}", {"node": plan.node})

    def _failed(self, node: Node, refusal: BootRefused) -> None:
        node.adopted = False
        wait = WAITS_S[min(node.attempts - 1, len(WAITS_S) - 1)] if refusal.dead else REFUSED_S
        node.due = time.monotonic() + wait
        node.health = Health.DEAD if refusal.dead else Health.REFUSED
        if str(refusal) != node.why:
            node.why = str(refusal)
            self._say("alarm", f"{node.name} (node {node.plan.node}) {node.health.value}: {refusal}", {"node": node.plan.node})

    def _carry(self, node: Node, plan: plans.Plan) -> Booted:
        """Carries the steps out; raises BootRefused as the plan does."""
        try:
            step = next(plan)
            while not self._stop.is_set():
                step = plan.send(self._answer(node, step))
        except StopIteration as end:
            booted = end.value
            assert isinstance(booted, Booted)
            return booted
        raise BootRefused("stopped", dead=True)

    def _answer(self, node: Node, step: steps.Step) -> Answer:
        match step:
            case steps.Read(index, sub):
                return self.upload(node.plan.node, index, sub)
            case steps.Write(index, sub, data):
                return self.download(node.plan.node, index, sub, data)
            case steps.Nmt(command, awaits):
                assert self._network is not None
                boots = node.boots
                node.state = -1
                self._network.send_message(cobid.NMT, bytes((command, node.plan.node)))
                return self._await(node, awaits, boots)
            case steps.Pause(ms):
                self._stop.wait(ms / 1000.0)
                return b""
            case steps.Now():
                return (time.monotonic_ns() // 1_000_000).to_bytes(8, "little")
            case steps.Sync(ms):
                self._link.send(cobid.SYNC, b"")  # only a tool's own port accepts it: the cycle's ring refuses SYNC
                self._stop.wait(ms / 1000.0)
                return b""

    def _await(self, node: Node, state: State | None, boots: int) -> Answer:
        end = time.monotonic() + BOOT_UP_S + self._in_line_s
        while state is not None and not self._stop.is_set():
            if (state is State.INITIALISING and node.boots > boots) or node.state == state:
                return b""
            node.news.clear()
            if not node.news.wait(max(0.0, end - time.monotonic())):
                return Silent.YES
        return b""

    def carry(self, number: int, plan: Generator[steps.Step, Answer, T], ends: Callable[[], str] = str) -> T:
        """A dialogue of a tool with a node that is started up; raises the plan's exceptions.

        `ends`: called before every step; a text ends the dialogue with EndedError.
        """
        node = self.nodes[number]
        with node.lock:
            step = next(plan)
            while True:
                if why := ends():
                    raise EndedError(why)
                try:
                    step = plan.send(self._answer(node, step))
                except StopIteration as end:
                    result: T = end.value
                    return result

    # ---- SDO -------------------------------------------------------------------------------------------------------------
    def upload(self, number: int, index: int, sub: int) -> Answer:
        """One object as bytes; the caller holds the node's lock."""
        return self._sdo(lambda: bounded_upload(self._remote[number].sdo, index, sub))

    def download(self, number: int, index: int, sub: int, data: bytes) -> Answer:
        """One object written; b"" when the node took it."""
        return self._sdo(lambda: self._remote[number].sdo.download(index, sub, data) or b"")

    def _sdo(self, job: Callable[[], bytes]) -> Answer:
        for _ in range(SDO_TRIES):
            try:
                return job()
            except SdoAbortedError as error:
                return Refused(error.code)
            except (SdoCommunicationError, SdoError, can.CanError):
                if self._stop.is_set():
                    break
        return Silent.YES
