"""RK512, the station is active: its command gets every wrong reaction, and it must still work (serial-protocols 2.2, 2.6).

The status its program receives is not visible on the line; the line does show that the station neither hangs nor repeats
endlessly, and that it sends the next job.
"""

from collections.abc import Callable

from gateway.conformance.suites.line import BETWEEN, LineTester
from gateway.conformance.suites.p3964r.send import BY_ITSELF
from gateway.conformance.suites.rk512.telegrams import (
    DX_SEND,
    FETCH,
    PIECE,
    SEND,
    TYPES,
    finish,
    is_command,
    meant_as_command,
    right_reaction,
    size_of,
)
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, Inconclusive, NotApplicable
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

FIRST, ERROR = "RK512_ACT_BV_01", "RK512_ACT_BI_01"
OTHER_ERRORS = (11, 12)  # cases whose number is handled apart: one that stops at every error is one FAIL
ACT = Purposes[LineTester]("RK512_ACT", "active", "serial-protocols 2.2", condition=("active",), preamble=(FIRST,))
MOST_REPEATS = 12
MOST_WAIT = ms(20_000)  # for a missing reaction (CP 341); until then no job of its own follows


def command(t: LineTester, built: Callable[[bytes], bool] = is_command) -> bytes:
    """The station's command telegram, acknowledged on the link."""
    t.starts_sending()
    block = t.take()
    t.unanswered = b""  # by the case itself
    if not built(block.data):
        raise NotApplicable(f"the station's block {block.data[:10].hex(' ').upper()} is not an RK512 command")
    return block.data


@ACT.case(
    "BV_01",
    "its command telegram is well formed",
    "sein Befehlstelegramm ist richtig aufgebaut",
    clause="serial-protocols 2.1",
    preamble=(),
)
def well_formed(t: LineTester) -> None:
    for _ in range(1 if t.setup.stimulus_name == "operator" else 2):  # SEND and FETCH may come in turn
        _well_formed(t)


def _well_formed(t: LineTester) -> None:
    data = command(t, meant_as_command)
    if len(data) < 10 or data[1] != 0 or data[0] != 0:
        raise Fail(f"header {data[:10].hex(' ').upper()}", "00 00, command, type, address, amount, flag", data[:10].hex(" ").upper())
    _judge_size(data)
    _takes(t, data)


def _judge_size(data: bytes) -> None:
    size = size_of(data)
    wanted = 0 if data[2] == FETCH else min(size, PIECE)
    if size == 0 or len(data) - 10 != wanted:
        raise Fail(f"announces {size} bytes and carries {len(data) - 10}", f"{wanted} data bytes", data[:24].hex(" ").upper())


def _takes(t: LineTester, data: bytes) -> None:
    """Judge: the right reaction is acknowledged, if the link accepts another block; otherwise the link has failed."""
    reaction = right_reaction(data)
    got = t.block(wire_block(reaction, t.profile.block_check), "the right reaction")
    if got == Char.DLE:
        finish(t, data)
        return
    with t.given():
        t.settle()
        t.good(t.harmless)
    t.fail(f"the right reaction, {reaction[:8].hex(' ').upper()}", got, "DLE (10h)")


@ACT.case(
    "BV_03",
    "each of its commands names a known type and announces what it carries",
    "jeder seiner Befehle nennt einen bekannten Typ und kündigt an, was er trägt",
    clause="serial-protocols 2.1",
)
def each_command(t: LineTester) -> None:
    """Jobs of several kinds may come in turn."""
    for _ in range(1 if t.setup.stimulus_name == "operator" else 4):
        t.starts_sending()
        data = t.take().data
        _judge_header(data)
        _takes(t, data)
        t.settle(ms(150))


def _judge_header(data: bytes) -> None:
    shown = data[:12].hex(" ").upper()
    if len(data) < 10 or data[:2] != b"\0\0":
        raise Fail(f"header {shown}", "00 00, command, type, address, amount, flag", shown)
    if data[2] not in (SEND, FETCH, DX_SEND):
        raise Fail(f"byte 3 is {data[2]:02X}h: no command", "41h (A), 45h (E) or 4Fh (O)", shown)
    if data[3] not in TYPES:
        raise Fail(f"byte 4 is {data[3]:02X}h: no data type", "one of " + " ".join(map(chr, TYPES)), shown)
    _judge_size(data)


@ACT.case("BV_02", "after the right reaction it neither repeats nor complains", "nach der richtigen Reaktion wiederholt er nicht")
def once(t: LineTester) -> None:
    jobs = 1 if t.setup.stimulus_name == "operator" else 4  # jobs of several kinds may come in turn
    twice = [data for data in (_came_again(t) for _ in range(jobs)) if data]
    if len(twice) >= min(2, jobs):
        raise Fail("the command was sent again after the correct reaction", "nothing", twice[0][:16].hex(" ").upper())


def _came_again(t: LineTester) -> bytes:
    """A command that followed its own right reaction; N/A where the station sends it in a cycle."""
    data = command(t)
    _takes(t, data)
    got = t.answer(ms(300))
    if got is None:
        return b""
    if got != Char.STX:
        t.fail("the right reaction", got, "nothing")
    with t.given():
        again = t.take().data
        if is_command(again):
            t.good(right_reaction(again), "the right reaction")
            finish(t, again)
    if again != data or t.setup.stimulus_name == "periodic":
        return b""
    if t.answer(BY_ITSELF) == Char.STX:
        t.serve()
        raise NotApplicable("it also sends the same command unprompted")
    return data


def _next(t: LineTester) -> bytes:
    """Its next command; one that took the wrong reaction for none waits for the right one first."""
    try:
        return command(t)
    except Inconclusive:
        if t.answer(MOST_WAIT) != Char.STX:
            raise
        return t.take().data


def _wrong(number: int, summary: str, german: str, wrong: Callable[[bytes], bytes]) -> None:
    @ACT.case(
        f"BI_{number:02}",
        f"{summary}: the next job is sent and works",
        f"{german}: der nächste Auftrag kommt und läuft",
        clause="serial-protocols 2.2, 2.4",
        preamble=(FIRST, ERROR) if number in OTHER_ERRORS else None,
    )
    def body(t: LineTester) -> None:
        for turn in range(1 if t.setup.stimulus_name == "operator" else 2):
            if turn:
                _works(t, summary)  # the other one of two jobs in turn
            data = _next(t)
            said = wrong(right_reaction(data))
            if said:
                t.good(said, "a reaction telegram")
            else:
                t.silence(t.setup.reaction_wait + t.tolerance, "a command whose reaction never arrives")
            _quiet(t)
            _works(t, summary)


def _quiet(t: LineTester) -> None:
    """It may send again, but not for ever.  Jobs with a pause between them are those of its own cycle."""
    for _ in range(MOST_REPEATS):
        start = t.mark
        got = t.answer(t.profile.char_delay + ms(300))
        if got is None or (got == Char.STX and t.mark - start > BETWEEN and t.serve() is not None):
            return
        if got == Char.STX:
            with t.given():
                block = t.take()
            if is_command(block.data):
                t.good(right_reaction(block.data), "the right reaction")
                finish(t, block.data)
    if t.setup.stimulus_name != "periodic":
        raise Fail(f"repeats more than {MOST_REPEATS} times", "an end", "STX (02h)")


def _works(t: LineTester, after: str) -> None:
    """One that stops working is FAIL."""
    try:
        again = _next(t)
    except (Inconclusive, Fail) as ended:
        seen = ended.reason if isinstance(ended, Inconclusive) else "nothing"
        raise Fail(f"after {after} it sends no job any more: {seen}", "STX (02h) and a command", ended.got or "nothing") from ended
    t.good(right_reaction(again), "the right reaction to the next job")
    finish(t, again)
    got = t.answer(ms(100))
    if got not in (None, Char.STX):
        t.fail("the right reaction to the next job", got, "nothing")
    if got == Char.STX:
        t.serve()


for _number, (_summary, _german, _reaction) in enumerate(
    (
        ("a reaction with error number 14h", "eine Reaktion mit Fehlernummer 14h", lambda data: data[:3] + b"\x14"),
        ("a reaction with error number 10h", "eine Reaktion mit Fehlernummer 10h", lambda data: data[:3] + b"\x10"),
        ("a reaction with an unknown error number", "eine Reaktion mit unbekannter Fehlernummer", lambda data: data[:3] + b"\xee"),
        ("a reaction whose first byte is 55h", "eine Reaktion, deren erstes Byte 55h ist", lambda data: b"\x55" + data[1:]),
        ("a reaction whose second byte is 01h", "eine Reaktion, deren zweites Byte 01h ist", lambda data: data[:1] + b"\x01" + data[2:]),
        ("a reaction of three bytes", "eine Reaktion aus drei Bytes", lambda data: data[:3]),
        ("a reaction with two bytes too many", "eine Reaktion mit zwei Bytes zu viel", lambda data: data + b"\0\0"),
        ("a reaction with too little data", "eine Reaktion mit zu wenig Daten", lambda data: data[:-1] if len(data) > 4 else data[:3]),
        (
            "a command in place of the reaction",
            "ein Befehl statt der Reaktion",
            lambda data: bytes((0, 0, FETCH, 0x44, 5, 0, 0, 1, 0xFF, 0xFF)),
        ),
        ("no reaction at all", "gar keine Reaktion", lambda data: b""),
        ("a reaction with error number 2Ah", "eine Reaktion mit Fehlernummer 2Ah", lambda data: data[:3] + b"\x2a"),
        ("a reaction with error number 32h", "eine Reaktion mit Fehlernummer 32h", lambda data: data[:3] + b"\x32"),
    ),
    1,
):
    _wrong(_number, _summary, _german, _reaction)


@ACT.case("ST_01", "ten jobs in a row", "zehn Aufträge hintereinander")
def run(t: LineTester) -> None:
    for count in range(10 if t.setup.stimulus_name != "operator" else 2):
        data = command(t)
        t.good(right_reaction(data), f"the right reaction to job {count + 1}")
        finish(t, data)
        t.settle(ms(150))
