"""Active station: it sends a command telegram and gets faulty reactions of every kind; then it must still work (serial-protocols 6).

The line does not show what its program receives, but shows that it neither hangs nor repeats for ever, and serves the next job.
"""

from collections.abc import Callable

from gateway.conformance.case import Case, Cases
from gateway.conformance.serial.bench import Bench, Fail, NotRun, named
from gateway.conformance.serial.cases_rk512 import FETCH, SEND
from gateway.pure.lines.texts import said
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char

Wrong = Callable[[bytes], bytes]


def cases(reaction_time: Ns) -> list[Case]:
    """The list; `reaction_time`: how long the station waits for a reaction."""
    found = Cases("active")
    for name, title, wrong in (
        ("right", "the right reaction: no repeat, no complaint", None),
        ("error-number", "a reaction with error number 14h", lambda data: b"\0\0\0\x14"),
        ("wrong-first-byte", "a reaction whose first byte is 55h", lambda data: b"\x55" + data[1:]),
        ("short", "a reaction of 3 bytes", lambda data: data[:3]),
        ("too-long", "a reaction with two bytes too many", lambda data: data + b"\0\0"),
        ("command-instead", "a command telegram in place of the reaction", lambda data: b"\0\0\x45\x44\x05\0\0\x01\xff\xff"),
        ("never", "no reaction at all", lambda data: b""),
    ):
        _wrong_reaction(found, name, title, wrong, reaction_time)
    return found.all


def right_reaction(command: bytes) -> bytes:
    """The reaction of a good passive station, with zeros for data."""
    if len(command) < 10 or command[2] not in (SEND, FETCH):
        raise NotRun(said("the station's block {} is not an RK512 command", command[:10].hex(" ")))
    words = int.from_bytes(command[6:8], "big") if command[2] == FETCH else 0
    size = words if command[3] in b"EAM" else 2 * words
    return bytes(4 + min(size, 128))


def _wrong_reaction(found: Cases, name: str, title: str, wrong: Wrong | None, reaction_time: Ns) -> None:
    def run(bench: Bench) -> None:
        bench.make_it_send()
        reaction = right_reaction(bench.take())
        sent = reaction if wrong is None else wrong(reaction)
        if sent:
            bench.give_good(sent, "a reaction telegram")
        else:
            bench.silence(reaction_time + bench.tolerance, "a command whose reaction never arrives")
        bench.settle()
        bench.make_it_send("the job after that")
        again = bench.take()
        bench.give_good(right_reaction(again), "the right reaction to the next job")
        got = bench.answer(ms(100))
        if got not in (None, Char.STX):
            raise Fail(said("after the right reaction: {}", named(got)))

    found.add(name, title, run)
