"""The client with many devices: turns, retries, busy answers, polling, dead devices.  Virtual time."""

import random
import struct
from collections import Counter
from itertools import pairwise
from typing import Any

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.errors import DecodeError, EncodeError
from protocols.base.machine import Ns, ms
from protocols.modbus.crc import crc, sealed
from protocols.modbus.master import Master
from protocols.modbus.numbers import ORDERS, decode_number, encode_number
from protocols.modbus.orders import (
    Device,
    DeviceBack,
    DeviceLost,
    Done,
    Event,
    Failed,
    Failure,
    Group,
    Polled,
    PollFailed,
    Refused,
    read_pdu,
)
from protocols.modbus.timing import OVER_TCP, timing
from protocols.modbus.view import Kind
from protocols.modbus.wires import RtuWire, TcpWire

HOLDING = Kind.HOLDING_REGISTERS
READ = read_pdu(HOLDING, 0, 1)
WRITE = bytes.fromhex("06 0000 0001")
ANSWER = bytes.fromhex("03 02 1234")
T35 = timing(9600).t35


def tcp(transaction: int, pdu: bytes, unit: int = 1) -> bytes:
    return struct.pack(">HHHB", transaction, 0, len(pdu) + 1, unit) + pdu


def one(**settings: Any) -> Bench[Master]:
    """A master over TCP with one device `a`, open at 0."""
    master = Master(TcpWire(), [Device("a", **settings)])
    master.opened(0)
    return Bench(master)


# ------------------------------------------------------------------------------------------------------------ one order


def test_an_order_is_sent_and_its_answer_reported() -> None:
    line = one().at(ms(1)).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.at(ms(2)).hears(tcp(1, ANSWER)).reports(DeviceBack("a"), Done(1, "a", ANSWER))


def test_without_a_connection_an_order_fails_at_once() -> None:
    line = Bench(Master(TcpWire(), [Device("a")]))
    line.at(0).does(lambda m, now: m.order("a", READ, now)).says(b"").reports(Failed(1, "a", Failure.LOST))


def test_a_silent_device_is_asked_three_times_by_the_clock() -> None:
    line = one(timeout=ms(500), pause=ms(20), demote_after=9).at(0).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.at(ms(519)).says(b"").at(ms(520)).says(tcp(2, READ))
    line.at(ms(1039)).says(b"").at(ms(1040)).says(tcp(3, READ)).reports()
    line.at(ms(1540)).says(b"").reports(Failed(1, "a", Failure.TIMEOUT))


def test_the_time_runs_from_the_end_of_the_request() -> None:
    master = Master(TcpWire(), [Device("a", timeout=ms(100), retries=0)])
    master.opened(0)
    line = Bench(master, leaves_at_once=False)
    line.at(0).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.at(ms(900)).left().at(ms(999)).reports()
    line.at(ms(1000)).reports(Failed(1, "a", Failure.TIMEOUT))


def test_a_late_answer_to_a_request_given_up_is_not_taken_for_the_next_ones() -> None:
    line = one(timeout=ms(100), retries=1, demote_after=9).at(0).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.at(ms(100)).says(tcp(2, READ)).hears(tcp(1, ANSWER)).reports()
    line.hears(tcp(2, bytes.fromhex("03 02 4321"))).reports(DeviceBack("a"), Done(1, "a", bytes.fromhex("03 02 4321")))


def test_a_write_that_may_not_be_repeated_is_sent_once() -> None:
    line = one(timeout=ms(100), repeat_writes=False).at(0).does(lambda m, now: m.order("a", WRITE, now)).says(tcp(1, WRITE))
    line.at(ms(100)).says(b"").reports(Failed(1, "a", Failure.TIMEOUT))


@pytest.mark.parametrize(
    "answer",
    ["06 0000 0002", "06 0001 0001", "04 02 1234", "86", "86 02 00", "06 0000"],
)
def test_an_answer_that_does_not_fit_the_request_is_none(answer: str) -> None:
    line = one(retries=1).at(0).does(lambda m, now: m.order("a", WRITE, now)).says(tcp(1, WRITE))
    line.hears(tcp(1, bytes.fromhex(answer))).at(0).says(tcp(2, WRITE)).reports()


# ----------------------------------------------------------------------------------------------------- busy: 05 and 06


def test_06_is_asked_again_after_the_pause_until_it_is_done() -> None:
    line = one(busy_pause=ms(100)).at(0).does(lambda m, now: m.order("a", WRITE, now)).says(tcp(1, WRITE))
    line.hears(tcp(1, b"\x86\x06")).says(b"").reports(DeviceBack("a"))
    line.at(ms(99)).says(b"").at(ms(100)).says(tcp(2, WRITE))
    line.hears(tcp(2, WRITE)).reports(Done(1, "a", WRITE))


def test_05_to_a_write_means_taken_and_is_never_sent_again() -> None:
    line = one().at(0).does(lambda m, now: m.order("a", WRITE, now)).says(tcp(1, WRITE))
    line.hears(tcp(1, b"\x86\x05")).reports(DeviceBack("a"), Refused(1, "a", 5)).at(ms(1000)).says(b"")


def test_05_to_a_read_is_asked_again() -> None:
    line = one(busy_pause=ms(10)).at(0).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.hears(tcp(1, b"\x83\x05")).at(ms(10)).says(tcp(2, READ)).reports(DeviceBack("a"))


def test_busy_for_ever_ends_with_the_exception() -> None:
    line = one(busy_pause=ms(10), busy_retries=2).at(0).does(lambda m, now: m.order("a", READ, now))
    for n in range(1, 4):
        line.at(ms(10 * (n - 1))).says(tcp(n, READ)).hears(tcp(n, b"\x83\x06"))
    line.reports(DeviceBack("a"), Refused(1, "a", 6))


def test_any_other_exception_is_reported_at_once() -> None:
    line = one().at(0).does(lambda m, now: m.order("a", READ, now)).says(tcp(1, READ))
    line.hears(tcp(1, b"\x83\x02")).reports(DeviceBack("a"), Refused(1, "a", 2))


# -------------------------------------------------------------------------------------------------------------- polling


def test_a_group_is_read_on_its_grid() -> None:
    line = one().at(0).does(lambda m, now: m.poll(Group("g", "a", HOLDING, 0, 1, ms(100)), now)).says(tcp(1, READ))
    line.at(ms(30)).hears(tcp(1, ANSWER)).reports(DeviceBack("a"), Polled("g", (0x1234,)))
    line.at(ms(99)).says(b"").at(ms(100)).says(tcp(2, READ))
    line.at(ms(350)).hears(tcp(2, ANSWER)).reports(Polled("g", (0x1234,)))
    line.at(ms(399)).says(b"").at(ms(400)).says(tcp(3, READ))


def test_bits_come_one_by_one() -> None:
    line = one().at(0).does(lambda m, now: m.poll(Group("g", "a", Kind.COILS, 0, 10, ms(100)), now))
    line.says(tcp(1, bytes.fromhex("01 0000 000A"))).hears(tcp(1, bytes.fromhex("01 02 05 02")))
    line.reports(DeviceBack("a"), Polled("g", (1, 0, 1, 0, 0, 0, 0, 0, 0, 1)))


def test_a_large_group_is_read_in_pieces_and_reported_whole() -> None:
    line = one(most_words=2).at(0).does(lambda m, now: m.poll(Group("g", "a", HOLDING, 7, 3, ms(100)), now))
    line.says(tcp(1, read_pdu(HOLDING, 7, 2))).hears(tcp(1, bytes.fromhex("03 04 0001 0002"))).reports(DeviceBack("a"))
    line.says(tcp(2, read_pdu(HOLDING, 9, 1))).hears(tcp(2, bytes.fromhex("03 02 0003"))).reports(Polled("g", (1, 2, 3)))


def test_orders_go_first_but_never_starve_a_group() -> None:
    master = Master(TcpWire(), [Device("a"), Device("b", unit=2)])
    master.opened(0)
    master.poll(Group("g", "b", HOLDING, 0, 1, ms(10)), 0)
    seen, now = Counter[str](), 0
    for _ in range(200):
        frame = master.take_output()
        master.sent(now)
        seen[{1: "order", 2: "poll"}[frame[6]]] += 1
        master.order("a", READ, now)  # another one always waits
        now += ms(5)
        master.receive(frame[:4] + b"\x00\x05" + frame[6:7] + ANSWER, now)
    assert seen["order"] > 90 and seen["poll"] >= 45


def test_a_group_that_fails_is_reported_and_tried_again_on_its_grid() -> None:
    line = one(timeout=ms(10), retries=0, demote_after=9)
    line.at(0).does(lambda m, now: m.poll(Group("g", "a", HOLDING, 0, 1, ms(100)), now)).says(tcp(1, READ))
    line.at(ms(10)).reports(PollFailed("g", Failure.TIMEOUT)).at(ms(100)).says(tcp(2, READ)).hears(tcp(2, b"\x83\x02"))
    line.reports(DeviceBack("a"), PollFailed("g", 2))


# ------------------------------------------------------------------------------------------------- the connection is gone


def test_a_lost_connection_fails_what_waits_and_reports_each_group_once() -> None:
    line = one().at(0).does(lambda m, now: m.poll(Group("g", "a", HOLDING, 0, 1, ms(100)), now)).says(tcp(1, READ))
    line.hears(tcp(1, ANSWER)).reports(DeviceBack("a"), Polled("g", (0x1234,)))
    line.does(lambda m, now: m.order("a", WRITE, now)).says(tcp(2, WRITE)).does(lambda m, now: m.order("a", READ, now))
    line.loses_the_port().reports(
        Failed(1, "a", Failure.LOST), Failed(2, "a", Failure.LOST), PollFailed("g", Failure.LOST), DeviceLost("a")
    )
    line.at(ms(5000)).says(b"").reports()
    line.does(lambda m, now: m.opened(now)).says(tcp(3, READ)).hears(tcp(3, ANSWER)).reports(DeviceBack("a"), Polled("g", (0x1234,)))


# ----------------------------------------------------------------------------------------------------------- dead devices


class Plant:
    """Sixteen devices behind one line in virtual time; those in `silent` never answer, the others after 5 ms."""

    def __init__(self, silent: set[int], **settings: Any) -> None:
        devices = [Device(f"d{n}", unit=n, **settings) for n in range(1, 17)]
        self.master = Master(RtuWire(timing(19200)), devices)
        self.silent, self.now = silent, 0
        self.asked: list[tuple[Ns, int]] = []
        self.events: list[Event] = []
        self.master.opened(0)
        for n in range(1, 17):
            self.master.poll(Group(f"g{n}", f"d{n}", HOLDING, 0, 1, ms(200)), 0)

    def run(self, until: Ns) -> None:
        while self.now < until:
            frame = self.master.take_output()
            if frame:
                assert crc(frame) == 0
                self.now += len(frame) * timing(19200).char_ns
                self.asked.append((self.now, frame[0]))
                self.events += self.master.sent(self.now)
                if frame[0] not in self.silent:
                    self.now += ms(5)
                    self.events += self.master.receive(sealed(bytes((frame[0],)) + ANSWER), self.now)
                continue
            due = self.master.deadline()
            self.now = until if due is None else max(due, self.now)
            self.events += self.master.wake(self.now)


def test_one_dead_of_16_costs_the_others_one_request_a_probe_interval() -> None:
    plant = Plant({5}, timeout=ms(100), retries=2, demote_after=2, probe_every=ms(2000))
    plant.run(ms(62_000))
    to_dead = [at for at, unit in plant.asked if unit == 5 and at > ms(2000)]
    gaps = [later - earlier for earlier, later in pairwise(to_dead)]
    assert 25 <= len(to_dead) <= 31 and min(gaps) >= ms(2000), "one single request each interval"
    others = Counter(unit for at, unit in plant.asked if at > ms(2000))
    assert min(others[n] for n in range(1, 17) if n != 5) >= 0.9 * 60_000 / 200
    assert plant.events.count(DeviceLost("d5")) == 1 and plant.master.seen["d5"].losses == 1


def test_a_dead_device_is_back_within_its_interval_and_a_group_is_reported_lost_meanwhile() -> None:
    plant = Plant({5}, timeout=ms(100), probe_every=ms(2000))
    plant.run(ms(10_000))
    assert PollFailed("g5", Failure.TIMEOUT) in plant.events
    plant.silent.clear()
    plant.events.clear()
    plant.run(ms(12_300))
    assert DeviceBack("d5") in plant.events and Polled("g5", (0x1234,)) in plant.events
    plant.run(ms(16_000))
    assert sum(event == Polled("g5", (0x1234,)) for event in plant.events) >= 15, "polled on its own grid again"


def test_orders_to_a_dead_device_fail_at_once() -> None:
    plant = Plant({5}, timeout=ms(100))
    plant.run(ms(3_000))
    before = len(plant.asked)
    number = plant.master.order("d5", READ, plant.now)
    assert Failed(number, "d5", Failure.DEAD) in plant.master.wake(plant.now) and len(plant.asked) == before


def test_orders_of_one_device_are_bounded() -> None:
    master = Master(TcpWire(), [Device("a")])
    master.opened(0)
    numbers = [master.order("a", READ, 0) for _ in range(70)]
    failed = [event.order for event in master.wake(0) if isinstance(event, Failed)]
    assert failed == numbers[65:], "one under way, 64 wait"


# ----------------------------------------------------------------------------------------------------------------- RTU


def rtu(**settings: Any) -> Bench[Master]:
    master = Master(RtuWire(timing(9600)), [Device("a", **settings), Device("all", unit=0)])
    master.opened(0)
    return Bench(master)


def test_rtu_the_answer_is_taken_when_it_is_whole_and_silence_kept_before_the_next() -> None:
    line = rtu().at(0).does(lambda m, now: m.order("a", READ, now)).does(lambda m, now: m.order("a", WRITE, now))
    line.says(sealed(b"\x01" + READ)).hears(sealed(b"\x01" + ANSWER)).reports(DeviceBack("a"), Done(1, "a", ANSWER)).says(b"")
    line.at(T35 - 1).says(b"").at(T35).says(sealed(b"\x01" + WRITE))


def test_rtu_a_wrong_check_is_repeated_after_silence() -> None:
    line = rtu(retries=1).at(0).does(lambda m, now: m.order("a", READ, now)).says(sealed(b"\x01" + READ))
    line.hears(sealed(b"\x01" + ANSWER)[:-1] + b"\x00").at(T35 - 1).says(b"").at(T35).says(sealed(b"\x01" + READ)).reports()


def test_rtu_another_units_answer_is_passed_over_and_the_wait_goes_on() -> None:
    line = rtu(timeout=ms(100)).at(0).does(lambda m, now: m.order("a", READ, now)).says(sealed(b"\x01" + READ))
    line.hears(sealed(b"\x07" + ANSWER)).at(ms(20)).reports()
    line.hears(sealed(b"\x01" + ANSWER)).reports(DeviceBack("a"), Done(1, "a", ANSWER))


def test_rtu_a_broadcast_has_no_answer_but_a_turnaround() -> None:
    line = rtu().at(0).does(lambda m, now: m.order("all", WRITE, now)).says(sealed(b"\x00" + WRITE))
    line.at(ms(99)).reports().at(ms(100)).reports(Done(1, "all", b""))


def test_rtu_an_answer_whose_length_nothing_shows_ends_by_silence() -> None:
    ask, said = bytes.fromhex("2B 0E 04 00"), bytes.fromhex("2B 0E 04 83 00 00 01 00 02 41 42")
    line = rtu().at(0).does(lambda m, now: m.order("a", ask, now)).says(sealed(b"\x01" + ask))
    line.hears(sealed(b"\x01" + said)).reports().at(T35).reports(DeviceBack("a"), Done(1, "a", said))


def test_rtu_over_tcp_needs_no_silence() -> None:
    master = Master(RtuWire(OVER_TCP), [Device("a")])
    master.opened(0)
    line = Bench(master).at(0).does(lambda m, now: m.order("a", READ, now)).does(lambda m, now: m.order("a", READ, now))
    line.says(sealed(b"\x01" + READ)).hears(sealed(b"\x01" + ANSWER)).says(sealed(b"\x01" + READ))
    line.reports(DeviceBack("a"), Done(1, "a", ANSWER))


@pytest.mark.parametrize("seed", range(5))
def test_answers_over_a_bad_line_are_right_or_failed(seed: int) -> None:
    """A third of the answers is spoiled, cut or missing: what is told as done was answered just so."""
    chance, master, now, told = random.Random(seed), Master(RtuWire(timing(19200)), [Device("a", retries=1, demote_after=99)]), 0, 0
    master.opened(now)
    for n in range(300):
        master.order("a", read_pdu(HOLDING, n, 1), now)
        done: list[Event] = []
        while not any(isinstance(event, Done | Failed) for event in done):
            frame = master.take_output()
            if frame:
                done += master.sent(now)
                answer = bytearray(sealed(b"\x01\x03\x02" + frame[2:4]))
                kind = chance.randrange(9)
                if kind == 0:
                    answer[chance.randrange(len(answer))] ^= 1 << chance.randrange(8)
                elif kind == 1:
                    del answer[chance.randrange(len(answer)) :]
                elif kind == 2:
                    answer.clear()
                now += ms(3)
                done += master.receive(bytes(answer), now) if answer else []
                continue
            due = master.deadline()
            assert due is not None
            now = max(now, due)
            done += master.wake(now)
        for event in done:
            if isinstance(event, Done):
                assert event.pdu == b"\x03\x02" + n.to_bytes(2, "big")
                told += 1
    assert 200 < told < 300


# ------------------------------------------------------------------------------------------------------------- numbers


@pytest.mark.parametrize(
    "order, words",
    [("ABCD", (0x4121, 0x999A)), ("CDAB", (0x999A, 0x4121)), ("BADC", (0x2141, 0x9A99)), ("DCBA", (0x9A99, 0x2141))],
)
def test_10_1_in_every_order(order: str, words: tuple[int, int]) -> None:
    assert encode_number(10.1, "REAL", order) == words
    assert decode_number(words, "REAL", order) == pytest.approx(10.1)


@pytest.mark.parametrize("type_, low, high", [("INT16", -32768, 32767), ("UINT32", 0, 2**32 - 1), ("INT64", -(2**63), 2**63 - 1)])
@pytest.mark.parametrize("order", ORDERS)
def test_whole_numbers_to_their_ends_and_not_beyond(type_: str, low: int, high: int, order: str) -> None:
    for value in (low, high, 1):
        assert decode_number(encode_number(value, type_, order), type_, order) == value
    beyond: list[float] = [low - 1, high + 1, float("nan"), float("inf")]
    for bad in beyond:
        with pytest.raises(EncodeError):
            encode_number(bad, type_, order)


def test_the_number_of_registers_must_fit() -> None:
    with pytest.raises(DecodeError):
        decode_number([1], "REAL")


# ---------------------------------------------------------------------------- values of a device that dies (AX-640)


class Groups:
    """Units with several groups each behind one TCP connection, in virtual time; those in `silent` take requests and never answer."""

    def __init__(self, units: int, groups: int, **settings: Any) -> None:
        self.master = Master(TcpWire(), [Device(f"d{n}", unit=n, **settings) for n in range(1, units + 1)])
        self.silent, self.unanswered, self.now = set[int](), set[int](), 0
        self.failed: dict[str, Ns] = {}
        self.good: set[str] = set()
        self.master.opened(0)
        for n in range(1, units + 1):
            for g in range(groups):
                self.master.poll(Group(f"d{n}.{g}", f"d{n}", HOLDING, g, 1, ms(200)), 0)

    def run(self, until: Ns) -> "Groups":
        while self.now < until:
            frame = self.master.take_output()
            if frame:
                self.take(self.master.sent(self.now))
                if frame[6] not in self.silent and int.from_bytes(frame[8:10], "big") not in self.unanswered:
                    self.now += ms(5)
                    self.take(self.master.receive(frame[:4] + b"\x00\x05" + frame[6:7] + ANSWER, self.now))
                continue
            due = self.master.deadline()
            self.now = until if due is None else max(due, self.now)
            self.take(self.master.wake(self.now))
        return self

    def take(self, events: list[Event]) -> None:
        for event in events:
            if isinstance(event, PollFailed):
                self.good.discard(event.group)
                self.failed.setdefault(event.group, self.now)
            elif isinstance(event, Polled):
                self.good.add(event.group)


def test_all_groups_of_a_dead_device_fail_with_the_first_one() -> None:
    plant = Groups(1, 12, timeout=ms(500), retries=2).run(ms(2000))
    assert len(plant.good) == 12
    plant.silent = {1}
    plant.run(ms(3750))  # three attempts of 500 ms, and the 200 ms of the groups' period
    assert plant.good == set() and len(plant.failed) == 12


def test_a_silent_connection_fails_the_groups_of_all_its_devices() -> None:
    plant = Groups(12, 1, timeout=ms(500), retries=2).run(ms(2000))
    plant.silent = set(range(1, 13))
    plant.run(ms(4250))  # one device given up, the second one silent for the first time
    assert plant.good == set() and len(plant.failed) == 12


def test_one_register_that_is_never_answered_takes_no_other_with_it() -> None:
    plant = Groups(1, 12, timeout=ms(100), retries=0)
    plant.unanswered = {5}
    plant.run(ms(10_000))
    assert set(plant.failed) == {"d1.5"} and len(plant.good) == 11


def test_one_dead_device_takes_no_other_with_it() -> None:
    plant = Groups(4, 3, timeout=ms(100), retries=1).run(ms(1000))
    plant.silent = {2}
    plant.run(ms(20_000))
    assert set(plant.failed) == {"d2.0", "d2.1", "d2.2"} and len(plant.good) == 9
