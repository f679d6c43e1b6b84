"""Two receive-only taps: characters that come late out of one adapter are put in their order by the protocol; the record says the same."""

import io

import pytest

from drivers.ports.serial.line_format import LineFormat
from gateway.links.serial.line_monitor import HOLD, Monitor, Recorder
from gateway.pure.lines.decoder import LineReport
from gateway.tools.line.learn import decoded, of_line
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import wire_block

SEND = bytes.fromhex("00004144 0A02 0002 FFFF 04B0 FEA2")
REACTION = bytes(4)


class Tap:
    """Batches as an adapter hands them over: (moment, characters); nothing can be said to it."""

    def __init__(self, clock: "Clock", batches: list[tuple[Ns, bytes | Damage]]) -> None:
        self.name, self.char_ns, self._clock, self._batches = "tap", 1_145_834, clock, batches

    def read(self) -> list[bytes | Damage]:
        due = [what for at, what in self._batches if at <= self._clock.now]
        self._batches = [batch for batch in self._batches if batch[0] > self._clock.now]
        return due

    def unsent(self) -> int:
        return 0

    def wait(self, seconds: float) -> None:
        self._clock.now += ms(2)

    def write(self, data: bytes) -> int:
        raise AssertionError("a monitor writes nothing")

    def spoil(self) -> bool:
        raise AssertionError("a monitor writes nothing")

    def send_break(self) -> bool:
        raise AssertionError("a monitor writes nothing")

    def close(self) -> None:
        pass


class Clock:
    now: Ns = 0


def heard(a: list[tuple[Ns, bytes | Damage]], b: list[tuple[Ns, bytes | Damage]]) -> tuple[list[LineReport], str]:
    clock, told, out = Clock(), list[LineReport](), io.StringIO()
    keep = Recorder(out, "tap", LineFormat(9600), 0)
    taps = [("A", Tap(clock, a)), ("B", Tap(clock, b))]
    Monitor(taps, lambda: clock.now, told.append, keep=keep).run(ms(400))
    return told, out.getvalue()


@pytest.mark.parametrize("late_b", [0, 3, 15])
def test_a_job_is_decoded_though_both_adapters_hand_over_in_lumps(late_b: int) -> None:
    """A: STX and the whole block at once, B: its DLE in the same lump or later; then the reaction the other way round."""
    first = b"\x02" + wire_block(SEND)
    told, record = heard(
        [(ms(20), first), (ms(60), b"\x10"), (ms(62), b"\x10")],
        [(ms(20 + late_b), b"\x10\x10"), (ms(60), b"\x02" + wire_block(REACTION))],
    )
    kinds = [(one.side, one.kind) for one in told]
    job = [("A", "STX"), ("B", "DLE"), ("A", "BLOCK"), ("B", "DLE"), ("B", "STX"), ("A", "DLE"), ("B", "BLOCK"), ("A", "DLE")]
    assert kinds == job
    assert [one.check_ok for one in told if one.kind == "BLOCK"] == [True, True]
    seen, draft = of_line(told, "COM5,COM6", LineFormat(9600))
    assert [(each.job, each.db, each.word, each.words) for each in seen.jobs] == [("SEND", 10, 2, 2)]
    assert "# Draft learned from COM5,COM6: 2 blocks" in draft
    assert [one.text for one in decoded(record)] == [one.text for one in told], "what was kept tells the same"


def test_a_character_nobody_answers_is_not_held_for_ever() -> None:
    told, _ = heard([(ms(20), b"\x02"), (ms(60), b"\x02")], [])
    assert [(one.side, one.kind) for one in told] == [("A", "STX"), ("A", "STX")]
    assert told[0].stamp == ms(20) and ms(20) >= HOLD


def test_damage_is_kept_in_the_record() -> None:
    _, record = heard([(ms(20), b"\x02"), (ms(24), Damage.PARITY)], [(ms(22), b"\x10")])
    assert " A 00 parity\n" in record
    assert record.startswith("# 0 ready name=tap baud=9600 bits=11")
