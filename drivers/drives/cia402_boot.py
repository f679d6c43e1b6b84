"""Start-up of one CiA 402 node as a plan of steps; the executor carries out each one and returns its answer.  Pure.

Source: CiA 301, 7.5.2 (objects 1000h..1A00h), CiA 302-2 (boot-up order), IEC 61800-7-201 (605Ah..605Eh, 6007h); AX-305, AX-307.

    plan = boot(node)
    step = next(plan)
    ...     step = plan.send(answer)        # StopIteration.value: Booted; BootRefused: the refused step and the object
"""

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

from drivers.drives.canopen_steps import Answer, Nmt, Pause, Read, Refused, Silent, Step, Write
from drivers.drives.cia402_states import Command as Control
from drivers.drives.cia402_states import State as PowerState
from drivers.drives.cia402_states import state_of
from protocols.canopen import cob_id as cobid
from protocols.canopen.nmt import Command, State
from protocols.canopen.pdo import RPDO_COMMUNICATION, RPDO_MAPPING, TPDO_COMMUNICATION, TPDO_MAPPING, Mapped, mapped
from protocols.canopen.sdo import Abort

CSP = 8
PROFILE = 402
CONTROLWORD, TARGET, MODE_WANTED = Mapped(0x6040, 0, 16), Mapped(0x607A, 0, 32), Mapped(0x6060, 0, 8)
STATUSWORD, POSITION, MODE_SHOWN = Mapped(0x6041, 0, 16), Mapped(0x6064, 0, 32), Mapped(0x6061, 0, 8)
TORQUE, LAG, INPUTS = Mapped(0x6077, 0, 16), Mapped(0x60F4, 0, 32), Mapped(0x60FD, 0, 32)
EVENT_DRIVEN = 255
MODE_TRIES, MODE_PAUSE_MS = 20, 10
START_TRIES, START_PAUSE_MS = 40, 10
STOP_TRIES, STOP_PAUSE_MS = 100, 20
PDOS = 4  # of each direction that a device may have valid from the factory and that are switched off when they are not ours


Plan = Generator[Step, Answer, "Booted"]


class BootRefused(Exception):
    """The node was not started; `dead`: it did not answer at all, so it is worth trying again."""

    def __init__(self, what: str, key: tuple[int, int] | None = None, *, dead: bool = False) -> None:
        super().__init__(what if key is None else f"{name_of(*key)}: {what}")
        self.key, self.dead = key, dead


# ---- settings --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Identity:
    """1018h; None: not pinned."""

    vendor: int | None = None
    product: int | None = None
    revision: int | None = None
    serial: int | None = None


@dataclass(frozen=True, slots=True)
class Parameter:
    """One value the drive is given; `why`: EDS, DCF, or the key of the cell."""

    index: int
    sub: int
    data: bytes
    why: str
    needed: bool = True  # False: a drive without the object is accepted all the same


@dataclass(frozen=True, slots=True)
class Pdo:
    """One PDO; number from 1; `transmission` as in sub-index 2."""

    receive: bool  # RPDO, seen from the drive
    number: int
    identifier: int
    transmission: int
    entries: tuple[Mapped, ...]
    inhibit_100us: int = 0
    event_ms: int = 0
    needed: bool = True  # False: left out when the drive cannot map it

    @property
    def communication(self) -> int:
        """Index of the communication parameters."""
        return (RPDO_COMMUNICATION if self.receive else TPDO_COMMUNICATION) + self.number - 1

    @property
    def mapping(self) -> int:
        """Index of the mapping parameters."""
        return (RPDO_MAPPING if self.receive else TPDO_MAPPING) + self.number - 1

    def __str__(self) -> str:
        return f"{'RPDO' if self.receive else 'TPDO'}{self.number}"


class Loss(Enum):
    """Reaction of the drive when the gateway's heartbeat is missing (`stop_on_bus_loss`)."""

    QUICK_STOP = "quick_stop"
    COAST = "coast"


@dataclass(frozen=True, slots=True)
class NodePlan:
    """All settings sent to one node."""

    node: int
    pdos: tuple[Pdo, ...]
    identity: Identity = Identity()
    parameters: tuple[Parameter, ...] = ()
    heartbeat_ms: int = 50  # producer time of both sides
    gateway: int = 127
    missed: int = 3  # heartbeats of the gateway that may stay away
    period_us: int = 4000
    loss: Loss = Loss.QUICK_STOP
    stop_evidence: str = ""  # how it is known that a drive without 6007h stops; empty: it is not
    known: frozenset[tuple[int, int]] | None = None  # objects the EDS lists; None: no EDS

    @property
    def consumer_ms(self) -> int:
        """Time without our heartbeat after which the drive reacts."""
        return self.heartbeat_ms * self.missed


@dataclass(frozen=True, slots=True)
class Booted:
    """A node that is operational and may get cyclic data."""

    node: int
    identity: Identity
    mode: int
    inputs: int
    options: dict[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    refused: str = ""  # of an I/O coupler: why its outputs are not driven while its inputs count


def default_pdos(node: int, *, torque: bool) -> tuple[Pdo, ...]:
    """AX-302; `torque`: the bus has room for a second TPDO in every cycle."""
    found = [
        Pdo(True, 1, cobid.rpdo(1, node), 1, (CONTROLWORD, TARGET)),
        Pdo(True, 2, cobid.rpdo(2, node), EVENT_DRIVEN, (MODE_WANTED,)),
        Pdo(False, 1, cobid.tpdo(1, node), 1, (STATUSWORD, POSITION)),
        Pdo(False, 3, cobid.tpdo(3, node), EVENT_DRIVEN, (INPUTS, MODE_SHOWN), event_ms=100),
    ]
    if torque:
        found.insert(3, Pdo(False, 2, cobid.tpdo(2, node), 1, (TORQUE, LAG), needed=False))
    return tuple(found)


PROBE_FUNCTION, PROBE_STATUS, PROBE_PLACES = 0x60B8, Mapped(0x60B9, 0, 16), (0x60BA, 0x60BC)  # places: rising edge, falling one next


def probe_pdos(node: int, probe: int, pdos: Iterable[Pdo]) -> tuple[Pdo, ...]:
    """PDOs of a drive with an active touch probe (1, 2): status after the inputs, positions at its edges, and the function that arms it."""
    place = PROBE_PLACES[probe - 1]
    found = [replace(pdo, entries=(*pdo.entries, PROBE_STATUS)) if INPUTS in pdo.entries else pdo for pdo in pdos]
    found.append(Pdo(True, 3, cobid.rpdo(3, node), EVENT_DRIVEN, (Mapped(PROBE_FUNCTION, 0, 16),)))
    found.append(Pdo(False, 4, cobid.tpdo(4, node), EVENT_DRIVEN, (Mapped(place, 0, 32), Mapped(place + 1, 0, 32)), event_ms=100))
    return tuple(found)


def probe_parameter(why: str) -> Parameter:
    """Off at first: the cycle arms it, and sees then whether the drive does."""
    return Parameter(PROBE_FUNCTION, 0, bytes(2), why)


NAMES = {
    0x1000: "device type", 0x1006: "communication cycle period", 0x1016: "heartbeat consumer", 0x1017: "heartbeat producer",
    0x1018: "identity", 0x6007: "abort connection option", 0x605A: "quick stop option", 0x605B: "shutdown option",
    0x605C: "disable operation option", 0x605D: "halt option", 0x605E: "fault reaction option", 0x6060: "mode", 0x6061: "mode display",
    0x60B8: "touch probe function", 0x60C2: "interpolation time", 0x6502: "supported modes",
}  # fmt: skip


def name_of(index: int, sub: int) -> str:
    """`6007h:00 abort connection option`."""
    pdo = {0x1400: "RPDO", 0x1600: "map of RPDO", 0x1800: "TPDO", 0x1A00: "map of TPDO"}.get(index & 0xFE00)
    known = f" {pdo}{(index & 0x1FF) + 1}" if pdo else f" {NAMES[index]}" if index in NAMES else ""
    return f"{index:04X}h:{sub:02X}{known}"


def map_faults(pdos: Iterable[Pdo]) -> list[str]:
    """6040h may be in one RPDO only (one controlword image), and 64 bits are all there are."""
    receive = [pdo for pdo in pdos if pdo.receive]
    places = [str(pdo) for pdo in receive for entry in pdo.entries if entry.index == CONTROLWORD.index]
    faults = (
        [f"6040h is mapped in {' and '.join(places)}: one of them would switch the drive off with its stale copy"]
        if len(places) > 1
        else []
    )
    for pdo in pdos:
        bits = sum(entry.bits for entry in pdo.entries)
        if bits > 64:
            faults.append(f"{pdo}: {bits} bits mapped, a frame has 64")
    return faults


# ---- the plan --------------------------------------------------------------------------------------------------------


def boot(plan: NodePlan) -> Plan:
    """From whatever state to operational.  Raises BootRefused."""
    faults = map_faults(plan.pdos)
    if faults:
        raise BootRefused("; ".join(faults))
    notes: list[str] = []
    yield from _stop_first()
    yield Nmt(Command.RESET_COMMUNICATION, State.INITIALISING)
    identity = yield from _identify(plan)
    yield from _modes()
    for parameter in (*plan.parameters, *_cycle_time(plan)):
        yield from _parameter(parameter, notes)
    yield from _guarding(plan)
    options = yield from _stop_options(plan, notes)
    yield from _map_all(plan, notes)
    mode = yield from _choose_csp()
    answer = yield Read(0x60FD)
    inputs = int.from_bytes(answer, "little") if isinstance(answer, bytes) else 0
    yield from _start()
    return Booted(plan.node, identity, mode, inputs, options, tuple(notes))


def _stop_first() -> Generator[Step, Answer, None]:
    """A drive that is still on (the boot-up message was not its own, a master died) brakes before it is reset."""
    for turn in range(STOP_TRIES):
        answer = yield Read(0x6041)
        state = state_of(int.from_bytes(answer, "little")) if isinstance(answer, bytes) else None
        if state not in (PowerState.ENABLED, PowerState.QUICK_STOP):
            return
        waits = state is PowerState.QUICK_STOP and turn < STOP_TRIES // 2
        if not waits:
            command = Control.QUICK_STOP if turn < STOP_TRIES // 2 else Control.DISABLE_VOLTAGE
            yield Write(0x6040, 0, command.value.to_bytes(2, "little"))
        yield Pause(STOP_PAUSE_MS)


def adopt(plan: NodePlan) -> Plan:
    """A node a predecessor has configured and which may be moving: looked at only."""
    identity = yield from _identify(plan)
    answer = yield Read(0x6061)
    mode = int.from_bytes(answer, "little", signed=True) if isinstance(answer, bytes) else CSP
    return Booted(plan.node, identity, mode, 0, {}, ("taken over as it was",))


def _identify(plan: NodePlan) -> Generator[Step, Answer, Identity]:
    kind = yield Read(0x1000)
    if kind is Silent.YES:
        raise BootRefused("no answer", (0x1000, 0), dead=True)
    profile = _number(kind, (0x1000, 0)) & 0xFFFF
    if profile != PROFILE:
        raise BootRefused(f"device profile {profile}; a CiA 402 drive has {PROFILE}", (0x1000, 0))
    found: list[int | None] = []
    wanted = (plan.identity.vendor, plan.identity.product, plan.identity.revision, plan.identity.serial)
    for sub, (what, pinned) in enumerate(zip(("vendor", "product", "revision", "serial number"), wanted, strict=True), 1):
        answer = yield Read(0x1018, sub)
        if answer is Silent.YES:
            raise BootRefused("no answer", (0x1018, sub), dead=True)
        value = int.from_bytes(answer, "little") if isinstance(answer, bytes) else None
        if pinned is not None and value != pinned:
            there = "nothing" if value is None else f"{value:#010x}"
            raise BootRefused(
                f"{what} {there} found, {pinned:#010x} is pinned: another drive is connected as node {plan.node}", (0x1018, sub)
            )
        found.append(value)
    return Identity(*found)


def _modes() -> Generator[Step, Answer, None]:
    answer = yield Read(0x6502)
    if isinstance(answer, bytes) and not int.from_bytes(answer, "little") >> (CSP - 1) & 1:
        raise BootRefused(f"{int.from_bytes(answer, 'little'):#x}: the drive has no cyclic synchronous position mode", (0x6502, 0))


def _cycle_time(plan: NodePlan) -> Sequence[Parameter]:
    """60C2h as value x 10^exponent s, 1006h in us; drives without them use the interval of SYNC."""
    value, exponent = plan.period_us, -6
    while value > 255 or (value % 10 == 0 and exponent < -3):
        value, exponent = value // 10, exponent + 1
    return (
        Parameter(0x1006, 0, plan.period_us.to_bytes(4, "little"), "cycle_ms", needed=False),
        Parameter(0x60C2, 1, bytes((value,)), "cycle_ms", needed=False),
        Parameter(0x60C2, 2, exponent.to_bytes(1, "little", signed=True), "cycle_ms", needed=False),
    )


def _parameter(parameter: Parameter, notes: list[str]) -> Generator[Step, Answer, None]:
    key = (parameter.index, parameter.sub)
    refused = yield from _write(*key, parameter.data, must=parameter.needed)
    if refused is not None:
        notes.append(f"{name_of(*key)} ({parameter.why}): {refused}")


def _write(index: int, sub: int, data: bytes, *, must: bool = True) -> Generator[Step, Answer, Refused | None]:
    """Write and read back; Refused (only for required objects) when the node rejects the value."""
    key = (index, sub)
    answer = yield Write(index, sub, data)
    if isinstance(answer, Refused):
        if must:
            raise BootRefused(f"refused {data.hex(' ')}: {answer}", key)
        return answer
    if answer is Silent.YES:
        raise BootRefused("no answer to a download", key, dead=True)
    back = yield Read(index, sub)
    if back != data:
        shown = back.hex(" ") if isinstance(back, bytes) else str(back)
        raise BootRefused(f"{data.hex(' ')} written, {shown} read back", key)
    return None


def _guarding(plan: NodePlan) -> Generator[Step, Answer, None]:
    """Heartbeat both ways; a drive that cannot watch the gateway is not started."""
    yield from _write(0x1016, 1, (plan.gateway << 16 | plan.consumer_ms).to_bytes(4, "little"))
    yield from _write(0x1017, 0, plan.heartbeat_ms.to_bytes(2, "little"))


OPTIONS = ((0x6007, "abort connection"), (0x605A, "quick stop"), (0x605B, "shutdown"), (0x605C, "disable operation"),
           (0x605D, "halt"), (0x605E, "fault reaction"))  # fmt: skip


WITHOUT_6007H = (
    ' and has no 6007h; measure its stop in a cell of its own (stop_evidence = "untested", axisgate drive loss-test CELL --running) and '
    "name the report here: stop_evidence of the axis"
)


def _stop_options(plan: NodePlan, notes: list[str]) -> Generator[Step, Answer, dict[str, int]]:
    """Written where it matters, all read; refused when the drive would run on (AX-307)."""
    wanted = {0x605A: 2, 0x6007: 3} if plan.loss is Loss.QUICK_STOP else {0x6007: 2}
    for index, value in wanted.items():
        answer = yield Write(index, 0, value.to_bytes(2, "little", signed=True))
        if isinstance(answer, Refused):
            notes.append(f"{name_of(index, 0)}: {value} refused: {answer}")
    found: dict[str, int] = {}
    absent = False
    for index, name in OPTIONS:
        answer = yield Read(index)
        if isinstance(answer, bytes):
            found[name] = int.from_bytes(answer, "little", signed=True)
        elif index == 0x6007:
            absent = isinstance(answer, Refused) and answer.code in (Abort.NO_OBJECT, Abort.NO_SUB)
    if absent and plan.stop_evidence:
        watched = f"its heartbeat consumer was read back ({plan.consumer_ms} ms)"
        notes.append(f"{name_of(0x6007, 0)}: the drive has none; {watched}; stop_evidence: {plan.stop_evidence}")
        return found
    why = runs_on(found, plan.loss) + (WITHOUT_6007H if absent else "")
    if why:
        raise BootRefused(f"not ready: {why}", (0x6007, 0))
    return found


def runs_on(options: dict[str, int], loss: Loss) -> str:
    """Why this drive would not stop as required when the heartbeat is missing; empty: it stops.  `options` by the names of OPTIONS."""
    abort = options.get("abort connection")
    if abort is None:
        return "the drive does not report its reaction to a missing gateway heartbeat"
    if abort not in (1, 2, 3):
        return f"{abort}: the drive runs on when the gateway's heartbeat stays away"
    if loss is Loss.COAST:
        return ""
    if abort == 2:
        return "2: the drive switches its voltage off and coasts; quick_stop is required"
    name = "fault reaction" if abort == 1 else "quick stop"
    option = options.get(name)
    if option == 0:
        return f"the drive coasts: its {name} option is 0"
    if option is None and abort == 1:
        return "the drive does not report its fault reaction"
    return ""


def _map_all(plan: NodePlan, notes: list[str]) -> Generator[Step, Answer, None]:
    """Every PDO that is not ours off, ours mapped; then no controlword may be left in a foreign one."""
    ours = {pdo.communication: pdo for pdo in plan.pdos}
    for base in (RPDO_COMMUNICATION, TPDO_COMMUNICATION):
        for index in range(base, base + PDOS):
            if index not in ours:
                yield from _switch_off(index)
    for pdo in plan.pdos:
        yield from _map(pdo, notes)


def _switch_off(index: int) -> Generator[Step, Answer, None]:
    answer = yield Read(index, 1)
    if not isinstance(answer, bytes):
        return  # it is not there
    identifier = int.from_bytes(answer, "little")
    if identifier & cobid.INVALID:
        return
    answer = yield Write(index, 1, (identifier | cobid.INVALID).to_bytes(4, "little"))
    if isinstance(answer, bytes) or index >= TPDO_COMMUNICATION:
        return
    count = yield Read(index + 0x200, 0)
    for sub in range(1, 1 + (count[0] if isinstance(count, bytes) and count else 0)):
        word = yield Read(index + 0x200, sub)
        if isinstance(word, bytes) and mapped(int.from_bytes(word, "little")).index == CONTROLWORD.index:
            raise BootRefused(f"6040h is mapped here too and the drive does not let this PDO be disabled: {answer}", (index + 0x200, sub))


def _map(pdo: Pdo, notes: list[str]) -> Generator[Step, Answer, None]:
    """The order that every device accepts: invalid, count 0, entries, count, type, valid; each read back."""
    off = (pdo.identifier | cobid.INVALID).to_bytes(4, "little")
    refused = yield from _write(pdo.communication, 1, off, must=pdo.needed)
    if refused is None:
        refused = yield from _write(pdo.mapping, 0, b"\0", must=pdo.needed)
    for sub, entry in enumerate(pdo.entries, 1):
        if refused is None:
            refused = yield from _write(pdo.mapping, sub, entry.word.to_bytes(4, "little"), must=pdo.needed)
    if refused is not None:
        notes.append(f"{pdo} left out: {refused}")
        return
    yield from _write(pdo.mapping, 0, bytes((len(pdo.entries),)))
    yield from _write(pdo.communication, 2, bytes((pdo.transmission,)))
    if not pdo.receive and pdo.transmission >= 254:
        for sub, value in ((3, pdo.inhibit_100us), (5, pdo.event_ms)):
            answer = yield Write(pdo.communication, sub, value.to_bytes(2, "little"))
            if value and isinstance(answer, Refused) and answer.code not in (Abort.NO_SUB, Abort.NO_OBJECT):
                raise BootRefused(f"refused {value}: {answer}", (pdo.communication, sub))
    yield from _write(pdo.communication, 1, pdo.identifier.to_bytes(4, "little"))


def _choose_csp() -> Generator[Step, Answer, int]:
    """Mode 8, and the drive shows it."""
    answer = yield Write(0x6060, 0, bytes((CSP,)))
    if isinstance(answer, Refused):
        raise BootRefused(f"mode {CSP} refused: {answer}", (0x6060, 0))
    shown: Answer = Silent.YES
    for _ in range(MODE_TRIES):
        shown = yield Read(0x6061)
        if shown == bytes((CSP,)):
            return CSP
        yield Pause(MODE_PAUSE_MS)
    raise BootRefused(f"mode {CSP} wanted, {shown.hex() if isinstance(shown, bytes) else shown} shown", (0x6061, 0))


def _start() -> Generator[Step, Answer, None]:
    answer = yield Nmt(Command.START, State.OPERATIONAL)
    if answer is Silent.YES:
        raise BootRefused("NMT start: the node's heartbeat does not show operational", dead=True)


def _number(answer: Answer, key: tuple[int, int]) -> int:
    if isinstance(answer, bytes):
        return int.from_bytes(answer, "little")
    raise BootRefused(str(answer.value if isinstance(answer, Silent) else answer), key)
