"""The loops around a byte machine: asyncio and the caller's thread, over a real line process, over TCP and over memory."""

import asyncio
import contextlib
import socket
import time
from collections.abc import AsyncIterator, Callable

import pytest

from drivers.ports.base import BytePort, PortError
from drivers.ports.open import open_bytes
from drivers.ports.serial.memory import memory_pair
from gateway.links.serial.runner import LineRunner
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.virtual.echo_machine import AllSent, EchoMachine, Event, Heard, HeardDamage, PortLost, Woken
from hil_tests.rig.serial.conftest import Rig, hear
from protocols.base.machine import Damage, Ns, ms

LineStarter = Callable[..., Rig]


class Station:
    """A runner with an echo machine and everything it reported."""

    def __init__(self, open_port: Callable[[], BytePort], *, answer: bool = False) -> None:
        self.machine = EchoMachine(answer=answer)
        self.events: list[Event] = []
        self.runner = LineRunner(open_port, self.machine, self._note)

    def say(self, data: bytes) -> None:
        self.machine.say(data)
        self.runner.kick()

    @property
    def heard(self) -> bytes:
        return b"".join(event.data for event in self.events if isinstance(event, Heard))

    def _note(self, event: Event, now: Ns) -> None:
        self.events.append(event)


@contextlib.asynccontextmanager
async def stations(*openers: Callable[[], BytePort], answer: bool = False) -> AsyncIterator[list[Station]]:
    """First station asks, the others answer if told to."""
    made = [Station(opener, answer=answer and index > 0) for index, opener in enumerate(openers)]
    try:
        await until(lambda: all(one.runner.state.connected for one in made))
        yield made
    finally:
        for one in made:
            one.runner.close()


async def until(predicate: Callable[[], bool], limit_s: float = 5.0) -> float:
    """Waits for something that has a limit; returns how long it took."""
    start = time.monotonic()
    while not predicate():
        assert time.monotonic() - start < limit_s, "did not happen in time"
        await asyncio.sleep(0.001)
    return time.monotonic() - start


def openers(rig: Rig) -> tuple[Callable[[], BytePort], Callable[[], BytePort]]:
    return (lambda: rig.port("a"), lambda: rig.port("b"))


def test_bytes_and_damage_reach_the_machine_in_line_order(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with stations(*openers(rig), answer=True) as (one, other):
            rig.control.damage("B", "parity", 2)
            one.say(b"abc")
            await until(lambda: one.heard == b"ac")
            assert [event for event in one.events if not isinstance(event, AllSent)] == [
                Heard(b"a"),
                HeardDamage(Damage.PARITY),
                Heard(b"c"),
            ]
            assert other.heard == b"abc"
            counters = one.runner.state.counters
            assert (counters.received, counters.sent, counters.damaged) == (2, 3, 1)

    asyncio.run(play())


def test_sent_is_reported_when_the_last_character_has_left_the_line(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with stations(*openers(rig)) as (one, other):
            one.say(bytes(100))
            await until(lambda: len(other.heard) == 100)
            await until(lambda: any(isinstance(event, AllSent) for event in one.events))
            (sent,) = [event for event in one.events if isinstance(event, AllSent)]
            last = rig.record().runs[-1].stamp_ns
            assert abs(sent.at - last) < 20_000_000, "not when it was written: that was 115 ms before"

    asyncio.run(play())


def test_deadlines_are_kept_better_than_asyncio_does(line: LineStarter) -> None:
    async def play() -> None:
        port, _other = memory_pair()
        async with stations(lambda: port) as (one,):
            late: list[int] = []
            for _ in range(40):
                one.events.clear()
                one.machine.wake_at(time.monotonic_ns() + ms(3.1))
                one.runner.kick()
                await until(lambda: bool(one.events))
                (woken,) = one.events
                assert isinstance(woken, Woken)
                assert woken.at >= woken.asked
                late.append(woken.at - woken.asked)
            assert sorted(late)[10] < 500_000, f"best quarter up to {sorted(late)[10]} ns late; rounded to milliseconds it would be 900,000"

    asyncio.run(play())


def test_an_earlier_deadline_replaces_a_later_one() -> None:
    async def play() -> None:
        port, _other = memory_pair()
        async with stations(lambda: port) as (one,):
            one.machine.wake_at(time.monotonic_ns() + ms(60_000))
            one.runner.kick()
            one.machine.wake_at(time.monotonic_ns() + ms(5))
            one.runner.kick()
            assert await until(lambda: bool(one.events)) < 1

    asyncio.run(play())


def test_a_later_deadline_is_not_woken_early() -> None:
    async def play() -> None:
        port, _other = memory_pair()
        async with stations(lambda: port) as (one,):
            for delay in (5, 60):
                asked = time.monotonic_ns() + ms(delay)
                one.machine.wake_at(asked)
                one.runner.kick()
            await until(lambda: bool(one.events))
            (woken,) = one.events
            assert isinstance(woken, Woken)
            assert (woken.asked, woken.at >= asked) == (asked, True)

    asyncio.run(play())


def test_unplugged_and_plugged_the_line_goes_on_at_once(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with stations(*openers(rig)) as (one, other):
            rig.control.unplug()
            one.say(b"lost")
            await until(lambda: rig.control.status()["lost"] == 4)
            rig.control.plug()
            one.say(b"found")
            assert await until(lambda: other.heard == b"found") < 0.5
            assert one.runner.state.counters.lost == 0

    asyncio.run(play())


def test_a_removed_adapter_is_opened_again_within_2_s_of_its_return(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with stations(*openers(rig)) as (one, other):
            rig.control.remove("A")
            await until(lambda: not one.runner.state.connected)
            assert one.events == [PortLost()]
            assert "wire0-a" in one.runner.state.why
            await until(lambda: one.runner.state.counters.refused >= 2)
            rig.control.insert("A")
            assert await until(lambda: one.runner.state.connected) < 2.0
            one.say(b"back")
            await until(lambda: other.heard == b"back")
            assert one.runner.state.why == ""

    asyncio.run(play())


def test_a_line_process_that_was_killed_and_started_again_is_found_again(line: LineStarter) -> None:
    rig = line("--baud", "9600")

    async def play() -> None:
        async with stations(*openers(rig)) as (one, other):
            rig.process.kill()
            rig.process.wait()
            await until(lambda: not one.runner.state.connected and not other.runner.state.connected)
            again = Rig(rig.name, rig._record.parent, "--baud", "9600")
            try:
                assert await until(lambda: one.runner.state.connected and other.runner.state.connected) < 2.0
                one.say(b"hello")
                await until(lambda: other.heard == b"hello")
            finally:
                again.end()

    asyncio.run(play())


def test_what_is_said_while_the_port_is_away_leaves_when_it_is_back(line: LineStarter) -> None:
    rig = line("--baud", "0")

    async def play() -> None:
        async with stations(*openers(rig)) as (one, other):
            rig.control.remove("A")
            await until(lambda: not one.runner.state.connected)
            one.say(b"patience")
            rig.control.insert("A")
            await until(lambda: other.heard == b"patience")

    asyncio.run(play())


def test_a_machine_that_breaks_its_word_is_counted_and_the_line_starts_afresh(line: LineStarter) -> None:
    rig = line("--baud", "0")

    async def play() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: None)
        async with stations(*openers(rig)) as (one, other):
            one.say(b"raise")
            await until(lambda: other.runner.state.counters.machine_faults == 1)
            assert await until(lambda: other.runner.state.connected) < 2.0
            one.say(b"fine")
            await until(lambda: other.heard == b"fine")

    asyncio.run(play())


def test_a_listener_that_fails_does_not_cost_the_partner_his_answer() -> None:
    async def play() -> None:
        reported: list[object] = []
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: reported.append(context["exception"]))
        near, far = memory_pair()

        def fail(event: Event, now: Ns) -> None:
            raise KeyError("listener")

        runner = LineRunner(lambda: near, EchoMachine(answer=True), fail)
        await until(lambda: runner.state.connected)
        far.write(b"x")
        heard: list[bytes | Damage] = []

        def answered() -> bool:
            heard.extend(far.read())
            return bool(heard)

        await until(answered)
        assert heard == [b"x"]
        assert runner.state.connected
        assert [type(error) for error in reported][:1] == [KeyError]
        runner.close()

    asyncio.run(play())


def test_close_gives_everything_back_and_informs_the_machine() -> None:
    async def play() -> None:
        near, far = memory_pair()
        async with stations(lambda: near) as (one,):
            one.runner.close()
            one.runner.close()
            assert one.events == [PortLost()]
            with pytest.raises(PortError, match="closed"):
                far.write(b"x")

    asyncio.run(play())


def test_tcp_reconnects_by_itself_within_2_s() -> None:
    async def play() -> None:
        def listen(port: int) -> socket.socket:
            listener = socket.create_server(("127.0.0.1", port))
            listener.settimeout(5)
            return listener

        listener = listen(0)
        number = listener.getsockname()[1]
        async with stations(lambda: open_bytes(f"tcp://127.0.0.1:{number}", "0"), answer=False) as (one,):
            served, _ = await asyncio.to_thread(listener.accept)
            one.say(b"out")
            assert await asyncio.to_thread(served.recv, 10) == b"out"
            await until(lambda: any(isinstance(event, AllSent) for event in one.events))
            listener.close()
            served.close()
            await until(lambda: not one.runner.state.connected)
            await until(lambda: one.runner.state.counters.refused > 0)
            with listen(number) as listener:
                served, _ = await asyncio.to_thread(listener.accept)
                assert await until(lambda: one.runner.state.connected) < 2.0
                served.send(b"in")
                await until(lambda: one.heard == b"in")
                served.close()

    asyncio.run(play())


def test_one_dead_partner_does_not_slow_another() -> None:
    async def play() -> None:
        near, far = memory_pair()

        def never() -> BytePort:
            time.sleep(0.5)
            raise PortError("nobody there")

        dead = LineRunner(never, EchoMachine(), lambda event, now: None)
        async with stations(lambda: near, lambda: far, answer=True) as (one, _):
            for _ in range(50):
                one.events.clear()
                one.say(b"ping")
                assert await until(lambda: one.heard == b"ping") < 0.2
        await until(lambda: dead.state.why == "nobody there")
        dead.close()

    asyncio.run(play())


def test_the_threaded_loop_serves_the_same_machines(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    one, other = SyncLine(lambda: rig.port("a"), EchoMachine()), rig.port("b")
    machine = one._core.machine
    assert isinstance(machine, EchoMachine)
    machine.say(b"abc")
    assert one.run_until(lambda: any(isinstance(event, AllSent) for _, event in one.events), 2)
    assert hear(other, lambda items: len(items) == 3) == [b"a", b"b", b"c"]
    other.write(b"yes")
    assert one.run_until(lambda: b"".join(event.data for _, event in one.events if isinstance(event, Heard)) == b"yes", 2)
    rig.control.remove("A")
    assert one.run_until(lambda: not one.state.connected, 2)
    rig.control.insert("A")
    assert one.run_until(lambda: one.state.connected, 2)
    assert not one.run_until(lambda: False, 0.05)
    one.close()
    other.close()
