"""Gathers the evidence for `axisgate line diagnose` at one port; what it means is judged in gateway.pure.lines.diagnosis."""

import os
import pathlib
from collections.abc import Callable, Sequence

from gateway.conformance.serial.bench import Bench, Verdict
from gateway.conformance.serial.cases_rk512 import FETCH, TYPE_DB, header
from gateway.links.serial.tool_wire import Wire
from gateway.pure.lines.diagnosis import Evidence, Heard
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Priority, Profile

Opener = Callable[[str], Wire]  # line format -> the line
PATTERN = bytes(b"UZ3fLqwE" * 2)  # characters without a meaning in idle
LISTEN = ms(1000)
UNTOLD = ("COM", "com", "sim:")  # ports whose adapter's latency timer cannot be read; on Linux those that have one tell it
PATIENCE = ms(10_000)  # with an answer that did not come in time
ROUNDS = 5
BAUDS = (9600, 19200, 4800, 2400, 1200)
FRAMES = ("8E1", "8N1", "8O1")
FETCH_ANY = header(FETCH, TYPE_DB, 255, 0, 1)  # any reaction will do, an error number is one


def gather(opener: Opener, line_format: str, profile: Profile, priority: str, url: str = "", scan: bool = True) -> Evidence:
    """Looks at the line step by step and stops where a fault hides the rest."""
    seen = Evidence(line_format, priority)
    seen.latency_timer_ms, seen.latency_file = latency_timer(url)
    seen.hidden_adapter = seen.latency_timer_ms is None and (not url or url.startswith(UNTOLD))
    wire = opener(line_format)
    try:
        bench = Bench(wire, profile, Priority.LOW, None, None)
        seen.idle = _listen(bench, LISTEN)
        bench.say(PATTERN)
        seen.pattern, seen.returned = PATTERN, _listen(bench, ms(300))
        bench.pass_time(wire.now() + profile.char_delay)
        seen.answers[line_format] = _stx(bench)
        if not seen.answers[line_format]:
            _late(bench, seen)
        if seen.answers[line_format][:1] == [Char.DLE] and not _disturbed(seen):
            _partner(bench, seen)
    finally:
        wire.close()
    if scan and seen.late is None and seen.answers[line_format][:1] != [Char.DLE] and not _disturbed(seen):
        _scan(opener, seen, profile)
    return seen


def _disturbed(seen: Evidence) -> bool:
    """Something other than a partner's NAK came back from the pattern, or the idle line is not quiet."""
    return any(what != Char.NAK for what in seen.returned) or bool(seen.idle)


def _listen(bench: Bench, how_long: Ns) -> list[Heard]:
    """Everything that comes until it was quiet so long."""
    bench.mark = max(bench.mark, bench.wire.now())
    heard: list[Heard] = []
    while (got := bench.answer(how_long)) is not None and len(heard) < 200:
        heard.append(got)
    return heard


def _stx(bench: Bench) -> list[Heard]:
    """What comes after STX, until it is quiet: DLE, and NAK when the character delay is over."""
    bench.say(bytes((Char.STX,)))
    got = bench.answer(bench.profile.ack_delay)
    return [] if got is None else [got, *_listen(bench, bench.profile.char_delay + ms(100))]


def _late(bench: Bench, seen: Evidence) -> None:
    """Who says nothing in time may say it later: that is a slow partner, not a silent one."""
    start = bench.mark
    got = bench.answer(PATIENCE)
    if got is not None:
        seen.late, seen.late_after = got, bench.mark - start
        _listen(bench, bench.profile.char_delay + ms(100))


def _scan(opener: Opener, seen: Evidence, profile: Profile) -> None:
    """The other speeds and frames, the likely ones first; stops at the first that is answered."""
    ours = seen.our_format
    for name in sorted((f"{baud} {frame}" for baud in BAUDS for frame in FRAMES), key=lambda name: name.split()[0] != ours.split()[0]):
        if name == ours:
            continue
        wire = opener(name)
        try:
            seen.answers[name] = _stx(Bench(wire, profile, Priority.LOW, None, None))
        finally:
            wire.close()
        if seen.answers[name][:1] == [Char.DLE]:
            return


def _partner(bench: Bench, seen: Evidence) -> None:
    for _ in range(ROUNDS):
        bench.say(bytes((Char.STX,)))
        start, got = bench.mark, bench.answer(bench.profile.ack_delay)
        if got == Char.DLE:
            seen.answer_times.append(bench.mark - start)
        _listen(bench, bench.profile.char_delay + ms(100))
    for name, wire in checks():
        seen.checks[name] = _offer(bench, wire)
        _settle(bench)
        if name == "right" and seen.checks[name] == Char.DLE:
            continue
    _fetch(bench, seen)


def checks() -> Sequence[tuple[str, bytes]]:
    """Blocks as different partners expect them; all mean nothing to an RK512 station."""
    plain, doubled = wire_block(b"UV"), wire_block(b"U\x10V")
    return (
        ("right", plain),
        ("stx", plain[:-1] + bytes((plain[-1] ^ Char.STX,))),
        ("none", plain[:-1]),
        ("dle right", doubled),
        ("dle once", doubled[:-1] + bytes((doubled[-1] ^ Char.DLE,))),
    )


def _offer(bench: Bench, wire: bytes) -> Heard | None:
    bench.say(bytes((Char.STX,)))
    if bench.answer(bench.profile.ack_delay) != Char.DLE:
        return None
    bench.say(wire)
    return bench.answer(min(bench.profile.ack_delay, bench.profile.char_delay - ms(50)))


def _settle(bench: Bench) -> None:
    try:
        bench.settle()
    except Verdict:
        bench.pass_time(bench.wire.now() + ms(500))


def _fetch(bench: Bench, seen: Evidence) -> None:
    """A FETCH: is there a reaction, and who goes on when our STX meets the STX of it?"""
    if _offer(bench, wire_block(FETCH_ANY)) != Char.DLE:
        return
    seen.reaction = b""
    if bench.answer(ms(2000)) != Char.STX:
        return
    try:
        seen.reaction = bench.take()
    except Verdict as fault:
        seen.their_difference = Char.STX if "off by 02h" in str(fault) else None
        seen.reaction = b"\0\0\0\0"
        _settle(bench)
        return
    _settle(bench)
    if _offer(bench, wire_block(FETCH_ANY)) == Char.DLE and bench.answer(ms(2000)) == Char.STX:
        bench.say(bytes((Char.STX,)))
        seen.conflict = bench.answer(min(bench.profile.ack_delay // 2, ms(200)))
        _settle(bench)


def latency_timer(url: str) -> tuple[int | None, str]:
    """Latency timer of a USB adapter as Linux reports it; None where there is none."""
    name = os.path.basename(os.path.realpath(url)) if url.startswith("/dev/") else ""
    path = pathlib.Path(f"/sys/bus/usb-serial/devices/{name}/latency_timer")
    try:
        return (int(path.read_text()), str(path)) if name else (None, "")
    except (OSError, ValueError):
        return None, ""
