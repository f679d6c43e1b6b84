"""3964R without a port: how fast blocks are decoded, and how many telegrams a second of simulation carries.

The reference is the small station written by hand (hil_tests.lab.partners.by_hand_partner), which takes one character after another; it
runs in
alternating rounds on the same bytes and the same faults.
"""

import json
import random
import time
from collections.abc import Callable
from statistics import median

from hil_tests.lab.partners.by_hand_partner import ByHandPartner, Gave, Got
from hil_tests.lab.virtual.virtual_line import Faults, VirtualLine
from protocols.base.machine import Machine, Ns
from protocols.p3964r.characters import wire_block
from protocols.p3964r.events import BlockReceived, BlockSent, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

Figure = dict[str, object]
BLOCK_BYTES = 138
CHUNK = 32  # bytes a port hands over at once: half the FIFO of a common UART
ROUNDS = 5
FAULTS = Faults(drop=0.0003, damage=0.0005, flip=0.0003, delay=0.0002, longest_delay=200_000_000)


def decode_mbps(blocks: int = 1500) -> Figure:
    """Millions of block bytes a second through the receiving machine, from STX to the acknowledgement."""
    chance = random.Random(3964)
    payloads = [chance.randbytes(BLOCK_BYTES) for _ in range(blocks)]
    chunks = [chunk for payload in payloads for chunk in _chunks(wire_block(payload))]

    def ours() -> float:
        link = Link(RHO3, Priority.LOW)
        return _decode(link, chunks, lambda event: isinstance(event, BlockReceived), blocks)

    def by_hand() -> float:
        return _decode(ByHandPartner(False), chunks, lambda event: isinstance(event, Got), blocks)

    return _figure("3964r.decode_MBps", "MB/s", 1.0, *_alternate(ours, by_hand, blocks * BLOCK_BYTES / 1e6))


def _chunks(wire: bytes) -> list[bytes]:
    return [b"\x02"] + [wire[at : at + CHUNK] for at in range(0, len(wire), CHUNK)]


def _decode(machine: Machine[object], chunks: list[bytes], good: Callable[[object], bool], blocks: int) -> float:
    """Seconds for all chunks; as a port does: receive, take the answer, report it sent."""
    now: Ns = 0
    count = 0
    start = time.perf_counter()
    for chunk in chunks:
        now += 1_000_000
        for event in machine.receive(chunk, now):
            count += good(event)
        if machine.take_output():
            machine.sent(now)
    seconds = time.perf_counter() - start
    if count != blocks:
        raise RuntimeError(f"{count} of {blocks} blocks decoded")
    return seconds


def sim_telegrams_per_s(telegrams: int = 600) -> Figure:
    """Blocks of 138 bytes a second of computing time, two machines on a faulty line at 9600 Bd in virtual time."""
    chance = random.Random(3964)
    payloads = [chance.randbytes(BLOCK_BYTES) for _ in range(telegrams)]
    return _figure(
        "3964r.sim_telegrams_per_s", "telegrams/s", 2000.0, *_alternate(lambda: _ours(payloads), lambda: _by_hand(payloads), telegrams)
    )


def _ours(payloads: list[bytes]) -> float:
    left, right = Link(RHO3, Priority.HIGH), Link(RHO3, Priority.LOW)

    def give(payload: bytes, now: Ns) -> None:
        left.send(payload, now)

    return _simulate(left, right, give, lambda event: isinstance(event, BlockSent | SendFailed), payloads)


def _by_hand(payloads: list[bytes]) -> float:
    left, right = ByHandPartner(True), ByHandPartner(False)
    return _simulate(left, right, left.give, lambda event: isinstance(event, Gave), payloads)


def _simulate(
    left: Machine[object], right: Machine[object], give: Callable[[bytes, Ns], None], over: Callable[[object], bool], payloads: list[bytes]
) -> float:
    """Seconds until every payload was acknowledged or given up, one after another."""
    ended = 0

    def note(side: int, event: object, now: Ns) -> None:
        nonlocal ended
        ended += side == 0 and over(event)

    line = VirtualLine[object](left, right, note, 3964, FAULTS)
    start = time.perf_counter()
    for number, payload in enumerate(payloads, 1):
        give(payload, line.now)
        line.kick(0)
        while ended < number:
            line.step()
    return time.perf_counter() - start


def _alternate(ours: Callable[[], float], reference: Callable[[], float], amount: float) -> tuple[float, float]:
    """Median rates of both, measured in alternating rounds."""
    pairs = [(amount / ours(), amount / reference()) for _ in range(ROUNDS)]
    return median(pair[0] for pair in pairs), median(pair[1] for pair in pairs)


def _figure(name: str, unit: str, goal: float, value: float, reference: float) -> Figure:
    return {
        "figure": name, "value": round(value, 2), "unit": unit, "reference": "station by hand, character by character",
        "reference_value": round(reference, 2), "ratio": round(value / reference, 2), "goal": f">= {goal:g}", "met": value >= goal,
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps([decode_mbps(), sim_telegrams_per_s()], indent=1))
