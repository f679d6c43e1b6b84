"""Issue 6, acceptance, the other half of test_one_hour: devices a Modbus client asks and modules on a CAN bus, going away and coming back
for an hour of virtual time; what routes make of them is right or marked.

What is right is known from what the devices answered, not from the routes.  A register is old once its group has failed; until then it may
be as old as its period and the patience of the client with every device of the line.
"""

import random

from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.routes.addresses import number_at, place_of, put_at
from gateway.pure.routes.route import Edge, Loss, RouteSettings, RouteTable
from protocols.base.machine import Frame, Ns, ms
from protocols.modbus.crc import sealed
from protocols.modbus.master import Master
from protocols.modbus.numbers import decode_number
from protocols.modbus.orders import Device, Event, Group, Polled, PollFailed
from protocols.modbus.timing import timing
from protocols.modbus.view import Kind
from protocols.modbus.wires import RtuWire

HOUR, STEP, EVERY = ms(3_600_000), ms(100), ms(2000)
DEVICES, TIMEOUT, RETRIES, PROBE = 4, ms(100), 1, ms(2000)
OLDEST = EVERY + DEVICES * (RETRIES + 1) * (TIMEOUT + ms(50)) + STEP
CHAR_NS = timing(19200).char_ns
BLOCK, LINES = 541, {30: "out"}


class Flaky:
    """Something that is there, and then not."""

    def __init__(self, chance: random.Random) -> None:
        self.up, self.outages, self._chance = True, 0, chance
        self._turn = self._until(0)

    def _until(self, now: Ns) -> Ns:
        return now + ms(self._chance.choice((50, 300, 900, 1500, 4000, 20_000)) + self._chance.randrange(200))

    def step(self, now: Ns, *, keep_up: bool) -> bool:
        """True: it is another than before."""
        before = self.up
        if now >= self._turn or keep_up:
            self.up, self._turn = keep_up or not self.up, self._until(now)
            self.outages += before and not self.up
        return self.up is not before


class Line:
    """Devices behind one RTU line that is lost as a whole now and then; `registers`: as the client of a cell keeps them."""

    def __init__(self, chance: random.Random) -> None:
        self.chance, self.now = chance, 0
        self.master = Master(RtuWire(timing(19200)), [Device(f"d{n}", n, TIMEOUT, 0, RETRIES, probe_every=PROBE) for n in self.numbers])
        self.there = {n: Flaky(chance) for n in self.numbers}
        self.port = Flaky(chance)
        self.said = dict.fromkeys(self.numbers, (0, 0))  # words of the last whole answer, and when
        self.registers: dict[int, int | None] = dict.fromkeys(self.numbers)
        self.master.opened(0)
        for n in self.numbers:
            self.master.poll(Group(str(n), f"d{n}", Kind.HOLDING_REGISTERS, 0, 1, EVERY), 0)

    numbers = range(1, DEVICES + 1)

    def step(self, until: Ns, *, keep_up: bool) -> None:
        for device in self.there.values():
            device.step(until, keep_up=keep_up)
        if self.port.step(until, keep_up=keep_up):
            if self.port.up:
                self.master.opened(self.now)
            else:
                self._note(self.master.lost(self.now))
        while self.now < until:
            frame = self.master.take_output()
            if frame:
                self.now += len(frame) * CHAR_NS
                self._note(self.master.sent(self.now))
                self._answer(frame[0])
                continue
            due = self.master.deadline()
            self.now = until if due is None else min(max(due, self.now), until)
            self._note(self.master.wake(self.now))

    def _answer(self, unit: int) -> None:
        if not self.there[unit].up:
            return
        word = self.chance.randrange(0x10000)
        self.now += ms(5)
        self.said[unit] = (word, self.now)
        self._note(self.master.receive(sealed(bytes((unit, 3, 2)) + word.to_bytes(2, "big")), self.now))

    def _note(self, events: list[Event]) -> None:
        for event in events:
            if isinstance(event, Polled):
                self.registers[int(event.group)] = event.values[0]
            elif isinstance(event, PollFailed):
                self.registers[int(event.group)] = None


def test_after_an_hour_of_devices_up_and_down_every_value_was_right_or_marked() -> None:
    chance = random.Random(2)
    line, module, bus = Line(chance), Flaky(chance), IoBus(IoSettings(2, (Block(88, 8, BLOCK),)), 0)
    out, sent, sent_ns, now = bytearray(32), bytes(8), 0, 0
    settings = [
        RouteSettings("held"), RouteSettings("scaled", scale=10.0, offset=-5.0, loss=Loss.ZERO),
        RouteSettings("late", loss=Loss.VALUE, loss_value=7.0, loss_after_ns=ms(500)), RouteSettings("edge", edge=Edge.CHANGE),
        RouteSettings("block", loss=Loss.ZERO), RouteSettings("bit"),
    ]  # fmt: skip
    ends = (("DW0", "u16"), ("DD2", "s32"), ("DW4", "KH"), ("DW5", "KF"), ("DW6", "KH"), ("D7.0", ""))
    targets = [place_of(f"DB30.{place}", form, "ABCD", {}, LINES) for place, form in ends]
    word, bit = place_of("EW 88", "KH", "ABCD", {}, LINES), place_of("E 90.5", "", "ABCD", {}, LINES)
    table = RouteTable(settings)
    valid, lost = [0] * len(settings), [0] * len(settings)
    while now < HOUR:
        now += STEP
        keep_up = now > HOUR - ms(8000)
        line.step(now, keep_up=keep_up)
        module.step(now, keep_up=keep_up)
        if module.up:
            sent, sent_ns = chance.randbytes(8), now
            bus.receive(Frame(BLOCK, sent, now), now)
        bus.cycle(now)
        trusted = not bus.untrusted()
        words = [line.registers[n] for n in line.numbers]
        read = [None if each is None else decode_number((each,), "INT16" if n == 3 else "UINT16", "ABCD") for n, each in enumerate(words)]
        table.step(now, [*read, *(number_at(place, bus.image) if trusted else None for place in (word, bit))])
        said = [line.said[n] for n in line.numbers]
        signed = said[3][0] - 0x10000 if said[3][0] & 0x8000 else said[3][0]
        right = [said[0][0], said[1][0] * 10 - 5, said[2][0], signed, int.from_bytes(sent[:2], "big"), sent[2] >> 5 & 1]
        stamps = [*(stamp for _, stamp in said), sent_ns, sent_ns]
        for n, route in enumerate(table.routes):
            if route.value is not None:
                put_at(targets[n], out, route.value)
            shown, old = number_at(targets[n], out), now - stamps[n]
            if route.valid:
                valid[n] += 1
                assert old <= (OLDEST if n < DEVICES else 0), f"{now / 1e9:.1f} s: {route.settings.name} is {old / 1e9:.1f} s old and valid"
                assert shown == right[n], f"{now / 1e9:.1f} s: {route.settings.name}"
            elif old > OLDEST:
                lost[n] += 1
                assert route.settings.loss is not Loss.ZERO or shown == 0
                assert route.settings.loss is not Loss.VALUE or old < OLDEST + ms(700) or shown == 7
    outages = [line.port.outages, module.outages, *(device.outages for device in line.there.values())]
    assert min(outages) > 100 and min(valid) > 2_000 and min(lost) > 1_000, (outages, valid, lost)
    assert all(route.valid for route in table.routes), "everything is back within 8 s"
