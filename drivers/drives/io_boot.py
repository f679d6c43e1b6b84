"""Start-up of a CiA 401 coupler as a plan of steps, in the language of canopen_steps.  Pure.

Source: CiA 301, 7.5.2 (1000h, 1016h, 1017h, 1018h, 1800h); CiA 401 (6005h, 6206h error mode outputs, 6207h error value outputs).
"""

from collections.abc import Generator
from dataclasses import dataclass

from drivers.drives.canopen_steps import Answer, Nmt, Read, Refused, Silent, Step, Write
from drivers.drives.cia402_boot import Booted, BootRefused, Identity, NodePlan, Plan, name_of
from protocols.canopen.nmt import Command, State

PROFILE = 401
ERROR_MODE, ERROR_VALUE, INTERRUPTS, RPDO1_MAP, TPDO1, CONSUMER, PRODUCER = 0x6206, 0x6207, 0x6005, 0x1600, 0x1800, 0x1016, 0x1017
INPUTS_ONLY = 0xFF  # `Booted.mode` of a coupler whose outputs are not driven
EVENT_MS = 100  # interval at which unchanged inputs are sent again


@dataclass(frozen=True, slots=True)
class CouplerPlan(NodePlan):
    """`falls`: byte of outputs (0 = channels 0..7) -> (mask of outputs with an error value, their values)."""

    falls: tuple[tuple[int, int, int], ...] = ()
    channels: int = 0  # outputs the cell uses: the highest channel and one
    inputs: bool = False  # the cell uses some


def boot(plan: CouplerPlan) -> Plan:
    """From any state to operational; `Booted.mode` is the length of RPDO1 in bytes as the coupler has it.  Raises BootRefused.

    A coupler that refuses the settings of its outputs (map, supervision of the gateway, error values) is started for its inputs alone.
    """
    notes: list[str] = []
    refused = ""
    yield Nmt(Command.RESET_COMMUNICATION, State.INITIALISING)
    identity = yield from _identity()
    yield from _write(PRODUCER, 0, plan.heartbeat_ms.to_bytes(2, "little"), notes)
    try:
        size = yield from _outputs(plan, notes)
    except BootRefused as refusal:
        if refusal.dead or not plan.inputs:
            raise
        size, refused = INPUTS_ONLY, f"its outputs are not driven: {refusal}"
    yield from _write(INTERRUPTS, 0, b"\1", notes, must=False)
    yield from _write(TPDO1, 5, EVENT_MS.to_bytes(2, "little"), notes, must=False)
    yield Nmt(Command.START, State.OPERATIONAL)
    return Booted(plan.node, identity, size, 0, {}, tuple(notes), refused)


def _outputs(plan: CouplerPlan, notes: list[str]) -> Generator[Step, Answer, int]:
    size = yield from _size(plan)
    yield from _write(CONSUMER, 1, (plan.gateway << 16 | plan.consumer_ms).to_bytes(4, "little"), notes, must=bool(plan.falls))
    for octet, mask, values in plan.falls:
        yield from _write(ERROR_VALUE, octet + 1, bytes((values,)), notes)
        yield from _write(ERROR_MODE, octet + 1, bytes((mask,)), notes)
    return size


def adopt(plan: CouplerPlan) -> Plan:
    """A coupler a predecessor has configured: looked at only, its outputs stay."""
    identity = yield from _identity()
    return Booted(plan.node, identity, 0, 0, {}, ("taken over as it was",))


def _identity() -> Generator[Step, Answer, Identity]:
    kind = yield Read(0x1000)
    if not isinstance(kind, bytes):
        raise BootRefused(str(kind) if isinstance(kind, Refused) else "no answer", (0x1000, 0), dead=kind is Silent.YES)
    profile = int.from_bytes(kind[:2], "little")
    if profile != PROFILE:
        raise BootRefused(f"device profile {profile}; a CiA 401 coupler has {PROFILE}", (0x1000, 0))
    found: list[int | None] = []
    for sub in (1, 2, 3, 4):
        answer = yield Read(0x1018, sub)
        found.append(int.from_bytes(answer, "little") if isinstance(answer, bytes) else None)
    return Identity(*found)


def _size(plan: CouplerPlan) -> Generator[Step, Answer, int]:
    """Bytes of the RPDO.  A coupler discards a shorter RPDO, so its own map counts; where it reports none, the cell's channels count."""
    needed = (plan.channels + 7) // 8
    count = yield Read(RPDO1_MAP, 0)
    if not isinstance(count, bytes) or not count or not needed:
        return needed
    bits = 0
    for sub in range(1, count[0] + 1):
        word = yield Read(RPDO1_MAP, sub)
        bits += word[0] if isinstance(word, bytes) and word else 0
    if bits < plan.channels:
        raise BootRefused(f"{bits} outputs mapped, the cell uses channel {plan.channels - 1}", (RPDO1_MAP, 0))
    return (bits + 7) // 8


def _write(index: int, sub: int, data: bytes, notes: list[str], *, must: bool = True) -> Generator[Step, Answer, None]:
    """A value that must be set, or one the coupler may lack."""
    answer = yield Write(index, sub, data)
    if isinstance(answer, bytes):
        return
    if answer is Silent.YES:
        raise BootRefused("no answer to a download", (index, sub), dead=True)
    if must:
        raise BootRefused(f"refused {data.hex(' ')}: {answer}", (index, sub))
    notes.append(f"{name_of(index, sub)}: {answer}")
