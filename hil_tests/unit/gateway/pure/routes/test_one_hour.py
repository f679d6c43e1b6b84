"""Issue 6, acceptance: 1 h of virtual time with links going up and down; every value is right or marked, and at the end all are right.

Two PLCs write data blocks every 100 ms while their links stand, a third one fetches what routes make of them.  What is right is known here
from what the writers sent, not from the routes: a valid target equals what the last telegram of its source carried, and that telegram is
no older than the silence the command source allows.
"""

import random
from collections.abc import Callable

from gateway.pure.arbitration.data_blocks import BlockHost, DataBlock, DataBlocks
from gateway.pure.arbitration.link_watch import LinkEvent, LinkWatch
from gateway.pure.image.addresses import RcBit
from gateway.pure.routes.addresses import number_at, place_of, put_at
from gateway.pure.routes.route import Edge, Loss, RouteSettings, RouteTable
from protocols.base.machine import Ns, ms

HOUR, STEP, EVERY, SILENCE = ms(3_600_000), ms(100), ms(100), ms(1000)
LINES = {10: "a", 20: "b", 30: "out"}
SYMBOLS: dict[str, RcBit] = {}


LATE = RouteSettings("late", loss=Loss.VALUE, loss_value=7.0, loss_after_ns=ms(500))
Right = Callable[[tuple[int, ...]], float]


class Writer:
    """A PLC that sends its block of four words while its link stands, and the command source that takes it."""

    def __init__(self, number: int, chance: random.Random) -> None:
        self.number, self.chance = number, chance
        block = DataBlock(number, 4, from_plc=True)
        self.source = DataBlocks(
            [block], (), None, BlockHost(lambda command: None, lambda name: 0.0, lambda name, text: None, lambda name, bit: None)
        )
        self.block = block
        self.watch = LinkWatch(SILENCE, has_life_word=False)
        self.up, self.turn, self.due, self.outages = True, self._until(0), 0, 0
        self.sent: tuple[int, ...] = ()
        self.sent_ns: Ns = -HOUR

    def _until(self, now: Ns) -> Ns:
        return now + ms(self.chance.choice((50, 300, 900, 1500, 4000, 20_000)) + self.chance.randrange(200))

    def step(self, now: Ns, *, keep_up: bool) -> None:
        if now >= self.turn or keep_up:
            self.up = keep_up or not self.up
            self.outages += not self.up
            self.turn = self._until(now)
        if self.up and now >= self.due:
            self.due = now + EVERY
            self.sent, self.sent_ns = tuple(self.chance.randrange(0x10000) for _ in range(4)), now
            self.watch.telegram(now, None)
            self.source.written(self.number, 0, b"".join(word.to_bytes(2, "big") for word in self.sent), now)
        if self.watch.wake(now) is LinkEvent.SILENT:
            self.source.restart()


def signed(word: int) -> int:
    return word - 0x10000 if word & 0x8000 else word


def test_after_an_hour_of_links_up_and_down_every_value_was_right_or_marked() -> None:
    chance = random.Random(1)
    a, b = Writer(10, chance), Writer(20, chance)
    out = bytearray(64)
    plan: list[tuple[str, str, str, str, RouteSettings, Writer, Right]] = [
        ("DB10.DW0", "KF", "DB30.DW0", "KF", RouteSettings("kf"), a, lambda w: signed(w[0])),
        ("DB10.DW1", "u16", "DB30.DD2", "s32", RouteSettings("wide", scale=10.0, offset=-5.0), a, lambda w: w[1] * 10 - 5),
        ("DB10.D2.3", "", "DB30.D4.0", "", RouteSettings("bit", loss=Loss.ZERO), a, lambda w: w[2] >> 3 & 1),
        ("DB20.DW0", "KH", "DB30.DW5", "KH", LATE, b, lambda w: w[0]),
        ("DB20.DW1", "KF", "DB30.DW6", "KF", RouteSettings("fits", low=-20000, high=20000), b, lambda w: signed(w[1])),
        ("DB20.DW2", "KF", "DB30.DW7", "KF", RouteSettings("edge", edge=Edge.CHANGE), b, lambda w: signed(w[2])),
    ]  # fmt: skip
    sources = [place_of(row[0], row[1], "ABCD", SYMBOLS, LINES) for row in plan]
    targets = [place_of(row[2], row[3], "ABCD", SYMBOLS, LINES) for row in plan]
    table = RouteTable([row[4] for row in plan])
    blocks = [row[5].block for row in plan]
    seen_valid, seen_lost, now = [0] * len(plan), [0] * len(plan), 0
    while now < HOUR:
        now += STEP
        for writer in (a, b):
            writer.step(now, keep_up=now > HOUR - ms(2000))
        table.step(now, [number_at(place, block.data) if block.fresh else None for place, block in zip(sources, blocks, strict=True)])
        for n, route in enumerate(table.routes):
            if route.value is not None:
                put_at(targets[n], out, route.value)
            writer, right = plan[n][5], plan[n][6]
            if route.valid:
                seen_valid[n] += 1
                assert now - writer.sent_ns <= SILENCE, f"{now / 1e9:.2f} s: {route.settings.name} is old and says it is valid"
                assert number_at(targets[n], out) == right(writer.sent), f"{now / 1e9:.2f} s: {route.settings.name}"
            elif now - writer.sent_ns > SILENCE:
                seen_lost[n] += 1
                if route.settings.loss is Loss.ZERO:
                    assert number_at(targets[n], out) == 0
                elif route.settings.loss is Loss.VALUE and now - writer.sent_ns > SILENCE + ms(500) + 2 * STEP:
                    assert number_at(targets[n], out) == 7
    assert min(a.outages, b.outages) > 100 and min(seen_valid) > 2_000 and min(seen_lost) > 2_000
    for n, route in enumerate(table.routes):
        last = plan[n][6](plan[n][5].sent)
        fits = route.settings.low <= last <= route.settings.high
        assert route.valid is fits
        assert not fits or number_at(targets[n], out) == last
