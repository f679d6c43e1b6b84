"""Gathers the evidence for `axisgate line diagnose` at one port; gateway.pure.lines.diagnosis judges it."""

import os
import pathlib
from collections.abc import Callable, Sequence

from gateway.conformance.serial.bench import QUIET, Bench, Verdict
from gateway.conformance.serial.cases_rk512 import FETCH, TYPE_DB, header
from gateway.links.serial.tool_wire import Wire
from gateway.pure.lines.diagnosis import Evidence, Heard, matches
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Priority, Profile

Opener = Callable[[str], Wire]  # line format -> the line
PATTERN = bytes(b"UZ3fLqwE" * 2)  # characters without a meaning in idle
LISTEN = ms(1000)
UNTOLD = ("COM", "com", "sim:")  # ports whose adapter's latency timer cannot be read; on Linux those that have one show it
PATIENCE = ms(10_000)  # with an answer that did not come in time
REACTION = ms(2000)
ROUNDS = 5
OWN_BLOCKS = 8  # of the partner, accepted while we listen; one that never pauses must not hold us
CONFLICTS = 8
NOT_SLOW = ms(40)
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
        seen.idle = _listen(bench, LISTEN, seen)
        bench.say(PATTERN)
        seen.pattern, seen.returned = PATTERN, _listen(bench, ms(300), seen)
        bench.pass_time(wire.now() + profile.char_delay)
        seen.answers[line_format] = _stx(bench, seen)
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
    """Whether sent characters came back, complete or damaged, or the idle line is not quiet."""
    back = bool(matches(seen.pattern, seen.returned)) or any(isinstance(what, Damage) for what in seen.returned)
    return back or any(what != Char.NAK for what in seen.idle)


def _listen(bench: Bench, how_long: Ns, seen: Evidence) -> list[Heard]:
    """Everything until it was quiet so long; the partner's own blocks are accepted, otherwise it repeats them into every test."""
    bench.mark = max(bench.mark, bench.wire.now())
    heard: list[Heard] = []
    most = len(seen.blocks) + OWN_BLOCKS
    while len(heard) < 200 and len(seen.blocks) < most and (got := bench.answer(how_long)) is not None:
        if got == Char.STX:
            _take(bench, seen)
        else:
            heard.append(got)
    return heard


def _take(bench: Bench, seen: Evidence) -> None:
    """The partner's block after its STX."""
    try:
        seen.blocks.append(bench.take())
    except Verdict:
        bench.say(bytes((Char.NAK,)))


def _connect(bench: Bench, seen: Evidence) -> Heard | None:
    """The answer to STX; if the partner requests the line at the same time it may send, and ours is tried again."""
    got: Heard | None = None
    for _ in range(CONFLICTS):
        bench.say(bytes((Char.STX,)))
        got = bench.answer(bench.profile.ack_delay)
        if got != Char.STX:
            break
        got = bench.answer(bench.profile.char_delay)  # both at once: DLE if it yields, nothing if it has priority
        if got is not None:
            break
        _take(bench, seen)
    return got


def _stx(bench: Bench, seen: Evidence) -> list[Heard]:
    """The answer to STX, until it is quiet: DLE, and NAK when the character delay is over."""
    own, begun = len(seen.blocks), max(bench.mark, bench.wire.now())
    got = _connect(bench, seen)
    if got == Char.DLE and len(seen.blocks) == own:
        seen.answer_times.append(bench.mark - begun - bench.wire.char_ns)
    return [] if got is None else [got, *_rest(bench, _slow(seen))]


def _rest(bench: Bench, slow: Ns = 0) -> list[Heard]:
    """What follows until it is quiet; `slow`: additional wait for a slow partner."""
    heard: list[Heard] = []
    while (got := bench.answer(bench.profile.char_delay + ms(100) + slow)) is not None and len(heard) < 200:
        heard.append(got)
    return heard


def _slow(seen: Evidence) -> Ns:
    """Longest answer time of a slow partner; 0: it is not slow."""
    longest = max(seen.answer_times, default=0)
    return longest if longest > NOT_SLOW else 0


def _late(bench: Bench, seen: Evidence) -> None:
    """A partner without an answer in time may answer later: it is slow, not silent."""
    start = bench.mark
    got = bench.answer(PATIENCE)
    if got is not None:
        seen.late, seen.late_after = got, bench.mark - start
        _rest(bench)


def _scan(opener: Opener, seen: Evidence, profile: Profile) -> None:
    """The other speeds and frames, the likely ones first; stops at the first that is answered."""
    ours = seen.our_format
    for name in sorted((f"{baud} {frame}" for baud in BAUDS for frame in FRAMES), key=lambda name: name.split()[0] != ours.split()[0]):
        if name == ours:
            continue
        wire = opener(name)
        try:
            seen.answers[name] = _stx(Bench(wire, profile, Priority.LOW, None, None), seen)
        finally:
            wire.close()
        if seen.answers[name][:1] == [Char.DLE]:
            return


def _partner(bench: Bench, seen: Evidence) -> None:
    for _ in range(ROUNDS):
        _stx(bench, seen)
    for name, wire in checks():
        seen.checks[name] = _offer(bench, wire, seen)
        _settle(bench, seen)
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


def _offer(bench: Bench, wire: bytes, seen: Evidence) -> Heard | None:
    if _connect(bench, seen) != Char.DLE:
        return None
    bench.say(wire)
    return bench.answer(bench.profile.ack_delay)


def _settle(bench: Bench, seen: Evidence) -> None:
    try:
        bench.settle(bench.profile.char_delay + QUIET + _slow(seen))
    except Verdict:
        bench.pass_time(bench.wire.now() + ms(500))


def _fetch(bench: Bench, seen: Evidence) -> None:
    """A FETCH: does a reaction come, and which station continues when our STX collides with the reaction's?"""
    if _offer(bench, wire_block(FETCH_ANY), seen) != Char.DLE:
        return
    seen.reaction = b""
    if not _asks(bench):
        return
    try:
        seen.reaction = bench.take()
    except Verdict as fault:
        seen.their_difference = Char.STX if "off by 02h" in str(fault) else None
        seen.reaction, seen.spoilt = None, fault.args[0]
        bench.say(bytes((Char.NAK,)))
        _settle(bench, seen)
        return
    _settle(bench, seen)
    if _offer(bench, wire_block(FETCH_ANY), seen) == Char.DLE and _asks(bench):
        bench.say(bytes((Char.STX,)))
        seen.conflict = bench.answer(min(bench.profile.ack_delay // 2, ms(200)) + _slow(seen))
        _settle(bench, seen)


def _asks(bench: Bench) -> bool:
    """The partner's STX, with or without stray characters before it."""
    end = bench.mark + REACTION
    while (left := end - bench.mark) > 0 and (got := bench.answer(left)) is not None:
        if got == Char.STX:
            return True
    return False


def latency_timer(url: str) -> tuple[int | None, str]:
    """Latency timer of a USB adapter as Linux reports it; None where there is none."""
    name = os.path.basename(os.path.realpath(url)) if url.startswith("/dev/") else ""
    path = pathlib.Path(f"/sys/bus/usb-serial/devices/{name}/latency_timer")
    try:
        return (int(path.read_text()), str(path)) if name else (None, "")
    except (OSError, ValueError):
        return None, ""
