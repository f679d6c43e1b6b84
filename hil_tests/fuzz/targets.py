"""What is fuzzed: every machine that listens to a partner over Modbus, 3964R or RK512."""

import random
import struct
from typing import Any

from gateway.pure.lines.rk512_link import Rk512Link
from hil_tests.fuzz.player import Player, Target
from hil_tests.lab.virtual.modbus_view import MemoryView
from hil_tests.soak.store import Store
from protocols.base.machine import Damage, Machine, Ns, ms
from protocols.modbus.answering import answer
from protocols.modbus.crc import sealed
from protocols.modbus.master import Master
from protocols.modbus.mbap import Closing, Framing, Request
from protocols.modbus.orders import Device, Done, Failed, Group, Refused, read_pdu
from protocols.modbus.rtu import RtuFraming, RtuTcpFraming
from protocols.modbus.station import Station
from protocols.modbus.timing import OVER_TCP, timing
from protocols.modbus.view import Kind
from protocols.modbus.wires import RtuWire, TcpWire
from protocols.p3964r.events import BlockReceived
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

STX, ETX, DLE, NAK = 0x02, 0x03, 0x10, 0x15
PDUS = [
    bytes.fromhex(text)
    for text in (
        *("01 0000 0010", "02 0000 07D0", "03 0000 007D", "04 0000 0001", "05 0000 FF00", "06 0000 1234", "07", "0B", "0C", "11"),
        *("08 0000 A537", "08 0001 0000", "08 000A 0000", "0F 0000 0010 02 FFFF", "10 0000 0002 04 0001 0002", "18 0000"),
        *("14 07 06 0001 0000 0002", "15 09 06 0001 0000 0001 1234", "16 0000 00F2 0025", "17 0000 0002 0000 0001 02 BEEF"),
        *("2B 0E 01 00", "2B 0E 04 FF", "41 00", "83 02", "03 04 0001 0002"),
    )
]
GOOD = bytes.fromhex("03 0000 0001")


# ------------------------------------------------------------------------------------------------------- Modbus servers


class Server:
    """A framing with a view: the complete server without its sockets."""

    def __init__(self, framing: Framing | RtuFraming | RtuTcpFraming, line: bool) -> None:
        self.framing, self.line = framing, line
        self.view, self.station = MemoryView(64), Station(serial=line)
        self.closed = False

    def receive(self, data: bytes, now: Ns) -> list[object]:
        return [] if self.closed else self._serve(self.framing.receive(data, now))

    def damaged(self, kind: Damage, now: Ns) -> list[object]:
        return self._serve(self.framing.damaged(kind, now))

    def sent(self, now: Ns) -> list[object]:
        return list(self.framing.sent(now))

    def wake(self, now: Ns) -> list[object]:
        return self._serve(self.framing.wake(now))

    def deadline(self) -> Ns | None:
        return self.framing.deadline()

    def take_output(self) -> bytes:
        return self.framing.take_output()

    def lost(self, now: Ns) -> list[object]:
        """A lost connection is followed by a new one."""
        events = self._serve(self.framing.lost(now))
        if not isinstance(self.framing, RtuFraming):
            self.framing, self.closed = type(self.framing)(), False
        return events

    def _serve(self, events: Any) -> list[object]:
        for event in events:
            if isinstance(event, Request):
                assert 0 < len(event.pdu) <= 253 or not self.line
                pdu = answer(event.pdu, self.view if event.unit == 1 else None, True, self.station)
                if self.station.listening_only:
                    self.station.listening_only = False  # its client's mistake; a fuzzer makes it all the time
                if pdu and not (self.line and event.unit != 1):
                    assert 2 <= len(pdu) <= 253 and pdu[0] & 0x7F == event.pdu[0] & 0x7F
                    self.framing.reply(event, pdu)
            elif isinstance(event, Closing):
                self.closed = True
        return list(events)


def _mbap(pdu: bytes, transaction: int = 7) -> bytes:
    return struct.pack(">HHHB", transaction, 0, len(pdu) + 1, 1) + pdu


def _reconnected(player: Player) -> None:
    server = player.machine
    if isinstance(server, Server) and server.closed:
        player.loses()


def _tcp_works(player: Player) -> None:
    """A half frame was closed at its limit; a good request is answered, on a new connection if need be."""
    _reconnected(player)
    player.hears(_mbap(GOOD))
    assert player.take() == _mbap(bytes((3, 2)) + _register(player)), "a good request is not answered"


def _rtu_works(player: Player) -> None:
    _reconnected(player)
    player.hears(sealed(b"\x01" + GOOD))
    player.passes(ms(5000))
    assert player.take() == sealed(b"\x01\x03\x02" + _register(player)), "a good request is not answered"


def _register(player: Player) -> bytes:
    server = player.machine
    assert isinstance(server, Server)
    return server.view.words[Kind.HOLDING_REGISTERS][0].to_bytes(2, "big")


def _is_rtu(said: bytes) -> None:
    assert len(said) >= 5, f"a frame of {len(said)} bytes"


# ------------------------------------------------------------------------------------------------------- Modbus clients


class Owner(Master):
    """A master whose owner remembers what it has asked; each order has exactly one result."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.open_orders: set[int] = set()


def _master(wire: TcpWire | RtuWire) -> Owner:
    owner = Owner(wire, [Device("a", 1, ms(100), retries=1), Device("b", 2, ms(100), busy_retries=3)])
    owner.opened(0)
    owner.poll(Group("g", "b", Kind.HOLDING_REGISTERS, 0, 200, ms(500)), 0)
    return owner


def _orders(machine: Machine[Any], chance: random.Random, now: Ns) -> None:
    assert isinstance(machine, Owner)
    if chance.random() < 0.5:
        machine.open_orders.add(machine.order(chance.choice("ab"), chance.choice(PDUS[:22]), now))
    if chance.random() < 0.1:
        machine.opened(now)


def _result(machine: Machine[Any], event: object) -> None:
    assert isinstance(machine, Owner)
    if isinstance(event, Done | Refused | Failed):
        assert event.order in machine.open_orders or machine.open_orders == set(), f"a second result of order {event.order}"
        machine.open_orders.discard(event.order)


def _master_works(player: Player) -> None:
    """Every order has had its result; after a new start one that is answered is done."""
    master = player.machine
    assert isinstance(master, Owner)
    assert master.open_orders == set(), f"orders without a result: {master.open_orders}"
    player.loses()
    player.passes(ms(1000))
    player.take()
    master.opened(player.now)
    number = master.order("a", read_pdu(Kind.HOLDING_REGISTERS, 0, 1), player.now)
    for _ in range(30):  # polls of the other device may come first and stay without an answer
        player.kick()
        said = player.take()
        if said[-8:] == sealed(b"\x01" + GOOD):
            player.hears(sealed(b"\x01\x03\x02\x00\x07"))
            break
        if said[-7:] == b"\x06\x01" + GOOD:
            player.hears(said[-12:-10] + b"\0\0\0\5\1\3\2\0\7")
            break
        player.passes(ms(20))
    done = [event for event in player.told if isinstance(event, Done) and event.order == number]
    assert done == [Done(number, "a", b"\x03\x02\x00\x07")], f"an answered order is not done: {player.told}"


# -------------------------------------------------------------------------------------------------------- 3964R, RK512


def _block(data: bytes) -> bytes:
    body = data.replace(b"\x10", b"\x10\x10") + bytes((DLE, ETX))
    check = 0
    for byte in body:
        check ^= byte
    return body + bytes((check,))


def _link_works(player: Player) -> None:
    """After a quiet line a good block is acknowledged and reported."""
    player.loses()
    player.passes(ms(60_000))
    player.take()
    player.told.clear()
    player.hears(bytes((STX,)))
    assert player.take()[-1:] == bytes((DLE,)), "a wish to send is not answered"
    player.hears(_block(b"\x00\x00after\x10all"))
    assert player.take() == bytes((DLE,)), "a good block is not acknowledged"
    assert BlockReceived(b"\x00\x00after\x10all") in player.told


def _sends(machine: Machine[Any], chance: random.Random, now: Ns) -> None:
    assert isinstance(machine, Link)
    if chance.random() < 0.2:
        machine.send(chance.randbytes(chance.choice((1, 20, 128))), now)


HEADER = bytes.fromhex("00 00 41 44 0A 00 00 02 FF FF")  # SEND of 2 words to DB 10, DW 0
FETCH = bytes.fromhex("00 00 45 44 0B 00 00 02 FF FF")


def _rk512_works(player: Player) -> None:
    """A SEND of the partner is taken, its reaction telegram comes."""
    player.loses()
    player.passes(ms(60_000))
    player.take()
    player.hears(bytes((STX,)))
    assert player.take()[-1:] == bytes((DLE,)), "a wish to send is not answered"
    player.hears(_block(HEADER + b"\x12\x34\x56\x78"))
    said = player.take()
    assert said[:1] == bytes((DLE,)), "the telegram is not acknowledged"
    if said[1:] != bytes((STX,)):
        player.passes(ms(50))
        said += player.take()
    assert said == bytes((DLE, STX)), "no reaction telegram is offered"
    player.hears(bytes((DLE,)))
    assert player.take() == _block(b"\0\0\0\0"), "the reaction telegram is not the good one"
    player.hears(bytes((DLE,)))


def _jobs(machine: Machine[Any], chance: random.Random, now: Ns) -> None:
    assert isinstance(machine, Rk512Link)
    if chance.random() < 0.1 and machine.active.pending < 8:
        if chance.random() < 0.5:
            machine.active.send(0, chance.randbytes(8), 10)
        else:
            machine.active.fetch(0, 4, 11)
        machine.start(now)


TALK = [
    *(bytes((STX,)) + _block(data) for data in (b"A", b"\x10\x10", bytes(range(64)), HEADER + b"\x12\x34\x56\x78", FETCH, bytes(4))),
    *(bytes((byte,)) for byte in (STX, DLE, NAK, ETX)),
    bytes((DLE, DLE)),
    bytes((DLE,)) + _block(b"\0\0\0\0"),
]

RTU = [sealed(bytes((unit,)) + pdu) for pdu in PDUS for unit in (1, 1, 2)]
TARGETS = (
    Target("modbus.tcp", lambda: Server(Framing(), line=False), [_mbap(pdu) for pdu in PDUS], _tcp_works),
    Target("modbus.rtu", lambda: Server(RtuFraming(timing(9600, patience=ms(50))), line=True), RTU, _rtu_works, judge=_is_rtu),
    Target("modbus.rtu_tcp", lambda: Server(RtuTcpFraming(), line=True), RTU, _rtu_works, judge=_is_rtu),
    Target(
        "modbus.client_tcp",
        lambda: _master(TcpWire()),
        [_mbap(p, n) for p in PDUS for n in (1, 2, 3)],
        _master_works,
        _orders,
        on_event=_result,
    ),
    Target("modbus.client_rtu", lambda: _master(RtuWire(timing(9600))), RTU, _master_works, _orders, on_event=_result),
    Target("modbus.client_rtu_tcp", lambda: _master(RtuWire(OVER_TCP)), RTU, _master_works, _orders, on_event=_result),
    Target("3964r.low", lambda: Link(PROFILES["rho3"], Priority.LOW), TALK, _link_works, _sends),
    Target("3964r.high", lambda: Link(PROFILES["siemens-cp341"], Priority.HIGH), TALK, _link_works, _sends),
    Target("rk512", lambda: Rk512Link(PROFILES["siemens-cp525"], Priority.LOW, Store(random.Random(1))), TALK, _rk512_works, _jobs),
)
