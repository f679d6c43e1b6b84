"""What a bus has to carry: the figures of can.md C4, whether it fits, and CANopen frames in words."""

import pytest

from gateway.pure.buses.decoder import canopen_text
from gateway.pure.buses.load import Traffic, judge, times
from protocols.base.machine import Frame

MEGABIT = 1_000_000


def old_protocol(axes: int, blocks: int = 0) -> list[Traffic]:
    plan = [Traffic("SYNC", 100, 0)]
    plan += [Traffic(f"set {n}", 200 + 10 * n, 8) for n in range(1, axes + 1)] + [
        Traffic(f"actual {n}", 600 + 10 * n, 8) for n in range(1, axes + 1)
    ]
    return plan + [Traffic(f"block {n}", 471 + n, 8) for n in range(blocks)]


@pytest.mark.parametrize(
    "axes, blocks, plain, worst, shortest",
    [(6, 0, 1379, 1675, 2), (6, 2, 1601, 1945, 3), (6, 20, 3599, 4375, 5), (3, 0, 713, 865, 1)],
)
def test_cycle_contents_of_can_md(axes: int, blocks: int, plain: int, worst: int, shortest: int) -> None:
    verdict = judge(old_protocol(axes, blocks), MEGABIT, 4)
    assert (verdict.cycle.plain, verdict.cycle.worst, verdict.shortest_ms) == (plain, worst, shortest)
    assert verdict.fits is (worst + 135 <= 4000) and plain < verdict.cycle.typical < worst


def test_the_typical_cycle_is_the_measured_one() -> None:
    """can.md: random data 1425 us for SYNC, six set and six actual values."""
    assert judge(old_protocol(6), MEGABIT, 4).cycle.typical == pytest.approx(1425, abs=8)
    assert times(Traffic("SYNC", 100, 0), 500_000).plain == 94, "half the rate, twice the time"


def test_slow_frames_count_by_their_share_but_may_fall_into_one_cycle_whole() -> None:
    plan = [*old_protocol(1), Traffic("heartbeat", 0x701, 1, every_ms=50), Traffic("SDO", 0x601, 8, acyclic=True)]
    verdict = judge(plan, MEGABIT, 5)
    assert verdict.cycle.plain == 47 + 2 * 111 + 55 / 10
    assert verdict.acyclic.worst == 135
    full = judge([Traffic("SYNC", 100, 0), Traffic("slow", 0x701, 8, every_ms=1000)], 125_000, 2)
    assert full.cycle.worst < 500 and not full.fits, "1080 us SYNC + frame and another one that had just begun: 2600 us"


@pytest.mark.parametrize(
    "frame, text",
    [
        (Frame(0, b"\x01\x00"), "NMT start all nodes"),
        (Frame(0, b"\x81\x05"), "NMT reset node node 5"),
        (Frame(0x80), "SYNC"),
        (Frame(0x705, b"\x05"), "heartbeat of node 5: operational"),
        (Frame(0x183, bytes.fromhex("371710270000")), "TPDO1 of node 3: 37 17 10 27 00 00"),
        (Frame(0x603, bytes.fromhex("4018100100000000")), "SDO request of node 3: read 1018h:01"),
        (Frame(0x583, bytes.fromhex("4318100178563412")), "SDO answer of node 3: is 1018h:01 = 305419896 (12345678h)"),
        (Frame(0x603, bytes.fromhex("2f60600008000000")), "SDO request of node 3: write 6060h:00 = 8 (08h)"),
        (Frame(0x583, bytes.fromhex("8000200000000206")), "SDO answer of node 3: abort 2000h:00: 06020000h no object"),
        (Frame(0x583, bytes.fromhex("80002000efbeadde")), "SDO answer of node 3: abort 2000h:00: DEADBEEFh code unknown to CiA 301"),
        (Frame(0x583, b"\x60\x00"), "SDO answer of node 3: 60 00 (an SDO has 8 bytes)"),
        (Frame(0x083, b"\x00"), "EMCY of node 3: an emergency has 8 bytes, 1 received: 00"),
    ],
)
def test_canopen_frames_in_words(frame: Frame, text: str) -> None:
    assert canopen_text(frame) == text


def test_an_emergency_names_its_code() -> None:
    assert canopen_text(Frame(0x083, bytes.fromhex("1186200000000000"))).startswith("EMCY of node 3: 8611h following error")
