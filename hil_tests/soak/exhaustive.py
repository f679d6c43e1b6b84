"""Every single fault at every position of every golden telegram: 255 replacements, drop, duplicate, four inserts.

After each the sender repeats as 3964R does; then a good block must come in.  At most one telegram may be lost, a wrong one is judged by
`framed` (link) and by length against header (RK512).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

from gateway.tools.progress import steps
from hil_tests.lab.virtual.rk512_blocks import Blocks
from hil_tests.soak.faulted_line import Item
from hil_tests.soak.judge import framed, payload_of
from protocols.base.machine import ms
from protocols.p3964r.characters import wire_block
from protocols.p3964r.events import BlockReceived
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.header import ErrorNumber
from protocols.rk512.passive import Passive

INSERTS = (0x00, 0xFF, 0x10, 0x02)
GOLDEN = tuple(  # serial-protocols 1.2, examples 1 to 12, and a full block
    bytes.fromhex(text)
    for text in (
        "411042",
        "010203",
        "0203101500",
        "10101010100310",
        "00000000",
        "00000010",
        "0000454D001000200604",
        "00004544050A0007FFFF",
        "000045441010" + "0010" + "FFFF",
        "00004144050100 08FFFF" + "0102030405060708090A0B0C0D0E0F10",
        "FF004144DEADBEEF",
        "FF004544",
        "00004144050000 10FFFF" + "00" * 32,
    )
)
GOOD = b"good"


@dataclass
class Outcome:
    """How many cases, and what became of them."""

    cases: int = 0
    taken: int = 0  # the fault did no harm
    link: int = 0  # delivered wrong, framing and check were right
    rk512: int = 0  # of these a SEND or FETCH of right form: wrong data or a wrong place
    bad: list[str] = field(default_factory=list)


def faults_of(wire: bytes) -> Iterator[tuple[str, bytes]]:
    """Name and spoiled wire."""
    for at, byte in enumerate(wire):
        for value in range(256):
            if value != byte:
                yield f"{at} = {value:02X}h", wire[:at] + bytes((value,)) + wire[at + 1 :]
        yield f"{at} dropped", wire[:at] + wire[at + 1 :]
        yield f"{at} doubled", wire[: at + 1] + wire[at:]
        for value in INSERTS:
            yield f"{value:02X}h before {at}", wire[:at] + bytes((value,)) + wire[at:]


def exhaust(stride: int = 1, offset: int = 0) -> Outcome:
    """All cases, or every `stride`-th."""
    outcome, number = Outcome(), 0
    for golden in steps("every single fault", GOLDEN) if stride == 1 else GOLDEN:
        wire = wire_block(golden)
        assert payload_of(wire) == golden
        for name, spoiled in faults_of(b"\x02" + wire):
            number += 1
            if number % stride == offset:
                outcome.cases += 1
                _case(outcome, golden, f"{golden.hex(' ')}: {name}", spoiled)
    return outcome


def _case(outcome: Outcome, golden: bytes, name: str, spoiled: bytes) -> None:
    """The spoiled telegram, silence, its repeat, another good one."""
    link, now = Link(RHO3, Priority.LOW), 0
    blocks: list[bytes] = []
    for characters in (spoiled, b"\x02" + wire_block(golden), b"\x02" + wire_block(GOOD)):
        for burst in (characters[:1], characters[1:]):  # a station waits for our DLE
            blocks += [event.data for event in link.receive(burst, now) if isinstance(event, BlockReceived)]
            link.take_output()
            link.sent(now)
        now += ms(600)
        link.wake(now)
        link.take_output()
    heard: list[Item] = [(0, byte) for byte in spoiled]
    starts = [at + 1 for at, byte in enumerate(spoiled) if byte == 0x02]
    possible = [found[0] for start in starts if (found := framed(heard, start, ms(220))) is not None]
    if blocks[-1:] != [GOOD] or golden not in blocks:
        outcome.bad.append(f"{name}: the link was not good again, {[block.hex() for block in blocks]}")
    first = blocks[0] if len(blocks) == 3 else None
    if first is None or first == golden:
        outcome.taken += first == golden
    elif first not in possible:
        outcome.bad.append(f"{name}: {first.hex(' ')} was delivered and not on the line")
    else:
        outcome.link += 1
        outcome.rk512 += _served(first)


def _served(block: bytes) -> bool:
    """RK512 takes it for a command it could carry out."""
    passive = Passive(_Everything({}))
    passive.telegram(block, 0)
    reaction = passive.take_output()
    return reaction is not None and reaction[3] == ErrorNumber.NONE


class _Everything(Blocks):
    """Every word of every block is there."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return bytes(2 * words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return None
