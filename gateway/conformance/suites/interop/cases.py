"""The profiles of the makers against a station: each case is one row, played once with the times and habits of each maker."""

import contextlib
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.interop.partner import Partner, joined
from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.rk512.telegrams import right_reaction
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import PROFILES, Priority, Profile
from protocols.rk512.dialects import DIALECTS

REFERENCE = "siemens-cp341"  # its times are the longest: who fails with it has no chance with the others


def _distinct() -> Iterator[str]:
    """Makers with distinct behaviour on the line."""
    seen: list[Profile] = []
    for name, profile in PROFILES.items():
        link = replace(profile, name="", source="", open_fields=())
        if link not in seen:
            seen.append(link)
            yield name


MAKERS = (REFERENCE, *(name for name in _distinct() if name != REFERENCE))
WITH_RK512 = tuple(name for name in MAKERS if name in DIALECTS and DIALECTS[name].reaction)
LATER = ms(400)  # a block that comes again comes within this
MANY = 5
CONTROLS = bytes((Char.STX, Char.ETX, Char.DLE, Char.DLE, Char.NAK, 0x00, 0xFF, 0x17, 0x10))
Body = Callable[[LineTester, Profile], None]


@dataclass(frozen=True, slots=True)
class Row:
    """One case of every maker."""

    name: str
    summary: str
    summary_de: str
    body: Body
    clause: str
    condition: tuple[str, ...] = ()
    preamble: tuple[str, ...] = ()  # rows of the same maker
    rk512: bool = False


def case_id(maker: str, row: str) -> str:
    return f"INTEROP_{maker.replace('-', '').upper()}_{row}"


def patience(profile: Profile, t: LineTester) -> Ns:
    """One job of either station with all its attempts."""
    slower = max(profile.ack_delay, t.profile.ack_delay)
    return 2 * max(profile.connect_attempts, t.profile.connect_attempts) * slower + ms(2000)


def opposite(t: LineTester, profile: Profile) -> Priority:
    """The two ends are set opposite; where the device's priority is not known, the maker's own default."""
    if t.setup.priority is None:
        return profile.priority
    return Priority.LOW if t.setup.priority is Priority.HIGH else Priority.HIGH


def partner(t: LineTester, profile: Profile, priority: Priority | None = None) -> Partner:
    """It has been running for some time: the NAK of its start is over."""
    chosen = opposite(t, profile) if priority is None else priority
    made = profile if t.profile.block_check else profile.plain()
    return Partner(t, replace(made, nak_at_start=False), chosen)


def clean(p: Partner) -> None:
    """It took more than one attempt: the two do work together, not well."""
    said = [*p.repeats, *(f"refused: {why}" for why in p.refused)]
    if said:
        raise Warn(f"{p.profile.name} needed repeats: {joined(said)}", "the first attempt", joined(said))


def sent(p: Partner, count: int, what: str, limit: Ns) -> None:
    """Wait until so many blocks of the maker's station are acknowledged."""
    if not p.play(lambda: p.sent >= count or bool(p.failed), limit) or p.failed:
        got = joined([*p.repeats, *(f"given up: {why}" for why in p.failed)]) or "nothing"
        raise Fail(f"{p.profile.name} cannot deliver {what}: {got}", "DLE (10h) to STX and to the block", got)


def made_to_send(t: LineTester) -> None:
    if t.setup.stimulus is None:
        raise NotApplicable("the bench names no [stimulus] and the station has none of its own")
    with t.given():
        t.setup.stimulus(t)


def arrived(t: LineTester, p: Partner, what: str, limit: Ns) -> bytes:
    """The device's block is at the maker's station, once."""
    reached(t, p, what, limit)
    p.quiet(LATER)
    again = [block for block in p.received[1:] if block == p.received[0]]
    if again and t.setup.stimulus_name != "periodic":
        raise Fail(f"{what} reaches {p.profile.name} {len(again) + 1} times", "once", hexed(again[0]))
    return p.received[0]


def reached(t: LineTester, p: Partner, what: str, limit: Ns) -> None:
    p.play(lambda: bool(p.received), t.setup.stimulus_wait + limit)
    if not p.received and not p.heard and p.profile.name != REFERENCE:
        raise Inconclusive(f"the station does not send for {t.setup.stimulus_name or 'its stimulus'}", "STX (02h)", "nothing")
    if not p.received:
        why = f": refused: {joined(p.refused)}" if p.refused else ""
        raise Fail(f"{what} does not reach {p.profile.name}{why}", "one whole block", t.last(24))


def block_of(t: LineTester, length: int) -> bytes:
    """Control characters in every place; for RK512 an unasked reaction, which starts nothing."""
    head = bytes(4) if t.setup.pics.get("rk512") else b""
    most = min(length, 132) if head else length
    return head + (CONTROLS * (most // len(CONTROLS) + 1))[: max(2, most - len(head))]


# ---- the link
def takes(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile)
    p.send(block_of(t, 20))
    sent(p, 1, "a block", patience(profile, t))
    clean(p)


def gives(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile)
    arrived(t, p, "its block", patience(profile, t))
    clean(p)


def longest(t: LineTester, profile: Profile) -> None:
    stated = t.setup.pics.get("most_received")
    most = min(profile.max_data, stated if isinstance(stated, int) else t.profile.most_received)
    p = partner(t, profile)
    data = block_of(t, most)
    p.send(data)
    sent(p, 1, f"a block of {len(data)} characters", patience(profile, t) + 4 * len(data) * t.wire.char_ns)
    clean(p)


def _both_done(p: Partner) -> bool:
    return bool(p.failed) or (p.sent > 0 and bool(p.received))


def conflict(t: LineTester, profile: Profile) -> None:
    first = opposite(t, profile)
    tried = [first] if t.setup.priority is not None else [first, Priority.LOW if first is Priority.HIGH else Priority.HIGH]
    for last, priority in enumerate(tried, 1 - len(tried)):
        made_to_send(t)
        p = partner(t, profile, priority)
        block = block_of(t, 12)
        heard = p.meets(block, t.setup.stimulus_wait)
        if heard != Char.STX:
            raise NotApplicable("the station's STX could not be met")
        limit = 2 * patience(profile, t)
        p.play(functools.partial(_both_done, p), limit)
        p.quiet(LATER)
        if p.sent and p.received:
            break
        if not last:
            lost = "the block of the station" if p.sent else f"the block of {profile.name}"
            expected = f"both blocks; {profile.name} {'with' if priority is Priority.HIGH else 'without'} priority"
            got = f"{p.sent} sent, {len(p.received)} received, {joined([*p.failed, *p.repeats, *p.refused]) or 'no fault reported'}"
            raise Fail(f"both send at once: {lost} is lost", expected, got)
        t.settle()
    if p.received.count(p.received[0]) > 1 and t.setup.stimulus_name != "periodic":
        raise Fail(f"both send at once: its block comes {p.received.count(p.received[0])} times", "once", hexed(p.received[0]))


def _spoilt(data: bytes) -> bytes:
    return data[:-1] + bytes((data[-1] ^ 0x40,))


def refused_once(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile)

    def one_bit(data: bytes) -> bytes:
        """Invert one bit of the first character of the block that is not a DLE and does not become one."""
        kept = len(p.heard) < 2 or p.heard[-2] == Char.DLE
        return data if kept or data[0] in (Char.DLE, Char.DLE ^ 1) else bytes((data[0] ^ 1,))

    p.hears = one_bit
    arrived(t, p, "its block after a NAK", 2 * patience(profile, t))
    if not p.refused:
        raise NotApplicable("its block has no character that can be spoilt here")


def damaged_once(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile)
    p.says = _spoilt
    p.send(block_of(t, 20))
    sent(p, 1, "a block that was spoilt on the way at first", 2 * patience(profile, t))
    if not p.repeats:
        raise Fail("a block with a wrong last character was acknowledged", "NAK (15h)", "DLE (10h)")


def unheard(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile)
    p.swallows = True
    reached(t, p, "its block", patience(profile, t))
    p.play(lambda: len(p.received) > 1, 2 * patience(profile, t))
    if p.received[1:2] != p.received[:1]:
        got = hexed(p.received[1]) if p.received[1:] else "nothing"
        raise Fail(f"the acknowledgement of {profile.name} was lost: its block does not come again", hexed(p.received[0]), got)
    p.quiet(LATER)


def no_buffer(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile)
    p.link.set_buffer_free(False, t.wire.now())
    made_to_send(t)
    p.play(lambda: bool(p.heard), t.setup.stimulus_wait)
    p.play(lambda: len(p.refused) > 1, profile.no_buffer_wait + ms(30))
    p.link.set_buffer_free(True, t.wire.now())
    arrived(t, p, "its block, refused at first because no buffer was free,", patience(profile, t))


def alternately(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile)
    for count in range(MANY if t.setup.stimulus_name not in ("operator", "periodic") else 1):
        p.send(block_of(t, 12 + count))
        sent(p, count + 1, f"block {count + 1}", patience(profile, t))
        p.received.clear()
        made_to_send(t)
        arrived(t, p, f"its block {count + 1}", patience(profile, t))


def restarted(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile)
    p.play(lambda: len(p.heard) >= 3, t.setup.stimulus_wait)
    p.restart(profile)
    reached(t, p, f"its block, during which {profile.name} was restarted,", 2 * patience(profile, t))
    p.quiet(LATER)  # it may come twice: 3964R has no numbers of blocks


# ---- RK512
def job(t: LineTester, p: Partner, give: Callable[[], object], what: str, limit: Ns) -> object:
    """One job of the maker's station, to its end; its event."""
    before = len(p.jobs)
    give()
    p.hand_over()
    p.play(lambda: any(hasattr(event, "job") for event in p.jobs[before:]), limit)
    ended = next((event for event in p.jobs[before:] if hasattr(event, "job")), None)
    if ended is None or type(ended).__name__ == "Failed":
        got = getattr(getattr(ended, "why", None), "name", "nothing")
        raise Fail(f"{p.profile.name}: {what} brings no valid reaction: {got}", "a reaction 00 00 00 00", f"{got}; heard: {t.last(16)}")
    return ended


def done(ended: object, p: Partner, what: str) -> bytes:
    number = getattr(ended, "number", None)
    if number is not None:
        raise Fail(f"{p.profile.name}: {what} is refused with {number:02X}h", "00h", f"{number:02X}h")
    data = getattr(ended, "data", b"")
    assert isinstance(data, bytes)
    return data


def long_enough(t: LineTester, profile: Profile) -> Ns:
    return 2 * patience(profile, t) + ms(10_000)


def fetches(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile).with_rk512()
    words = min(8, t.setup.words)
    what = f"FETCH DB{t.setup.db}.DW0, {words} words"
    done(job(t, p, lambda: p.active.fetch(0, words, block=t.setup.db), what, long_enough(t, profile)), p, what)
    clean(p)


def writes(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile).with_rk512()
    db, limit = t.setup.write[0], long_enough(t, profile)
    before = done(job(t, p, lambda: p.active.fetch(0, 2, block=db), f"FETCH DB{db}.DW0", limit), p, f"FETCH DB{db}.DW0")
    restore = functools.partial(p.active.send, 0, before, block=db)
    try:
        for data in (b"\x01\x02\x10\x04", before):
            give = functools.partial(p.active.send, 0, data, block=db)
            done(job(t, p, give, f"SEND DB{db}.DW0", limit), p, f"SEND DB{db}.DW0")
            back = done(job(t, p, lambda: p.active.fetch(0, 2, block=db), f"FETCH DB{db}.DW0", limit), p, "FETCH")
            if back != data:
                raise Fail(f"what {profile.name} wrote reads back differently", data.hex(" ").upper(), back.hex(" ").upper())
    except Fail:
        with contextlib.suppress(Fail):  # written words may be unreadable; the other makers find the former words
            p.quiet(LATER)
            job(t, p, restore, f"SEND DB{db}.DW0", limit)
        raise


def is_served(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile).with_rk512()
    arrived(t, p, "its command", patience(profile, t))
    p.play(lambda: p.sent > 0 or bool(p.failed), long_enough(t, profile))
    if not p.sent:
        got = joined(p.failed) or "nothing"
        raise Fail(f"it does not accept the reaction of {profile.name} to its own command", "DLE (10h)", got)
    p.quiet(LATER)


def misses(t: LineTester, profile: Profile) -> None:
    p = partner(t, profile).with_rk512()
    limit, what = long_enough(t, profile), f"FETCH of the missing DB{t.setup.missing}"
    ended = job(t, p, lambda: p.active.fetch(0, 1, block=t.setup.missing), what, limit)
    if getattr(ended, "number", None) is None:
        raise Fail(f"{what} is executed", "a refusal", hexed(right_reaction(bytes(10))))
    done(job(t, p, lambda: p.active.fetch(0, 1, block=t.setup.db), "the next FETCH", limit), p, "the next FETCH")


def both_ask(t: LineTester, profile: Profile) -> None:
    made_to_send(t)
    p = partner(t, profile).with_rk512()
    what = "a FETCH while its own command waits"
    done(job(t, p, lambda: p.active.fetch(0, 1, block=t.setup.db), what, long_enough(t, profile)), p, what)
    p.play(lambda: bool(p.received) and not p.link.pending, patience(profile, t))


LINK = "serial-protocols 1.3 to 1.6, profile of the maker"
JOB = "serial-protocols 2, dialect of the maker"
TAKES, GIVES, FETCH, AGAIN, LOST = "BV_01", "BV_02", "BV_11", "BI_01", "BI_03"
SENDS, PASSIVE, ACTIVE = ("sends",), ("passive",), ("active",)
ROWS = (
    Row(TAKES, "takes a block of {}", "nimmt einen Block von {}", takes, LINK),
    Row(GIVES, "its block reaches {}, once", "sein Block erreicht {}, einmal", gives, LINK, SENDS, (TAKES,)),
    Row("BV_03", "takes the longest block that {} sends", "nimmt den längsten Block, den {} sendet", longest, LINK, (), (TAKES,)),
    Row(
        "BV_04",
        "it and {} send at once: both blocks arrive",
        "es und {} senden zugleich: beide Blöcke kommen an",
        conflict,
        LINK,
        SENDS,
        (TAKES, GIVES),
    ),
    Row(AGAIN, "{} refuses its block: it repeats it", "{} lehnt seinen Block ab: es wiederholt ihn", refused_once, LINK, SENDS, (GIVES,)),
    Row(
        "BI_02",
        "a spoilt block of {} is refused, its repeat taken",
        "ein verfälschter Block von {} wird abgelehnt, die Wiederholung genommen",
        damaged_once,
        LINK,
        ("block_check",),
        (TAKES,),
    ),
    Row(
        LOST,
        "the acknowledgement of {} gets lost: it repeats its block",
        "die Quittung von {} geht verloren: es wiederholt seinen Block",
        unheard,
        LINK,
        SENDS,
        (GIVES,),
    ),
    Row(
        "TI_01",
        "{} has no free buffer at first: its block arrives afterwards",
        "{} hat zuerst keinen Puffer frei: sein Block kommt danach an",
        no_buffer,
        LINK,
        SENDS,
        (GIVES,),
    ),
    Row(
        "RC_01",
        "{} is restarted during its block: the block arrives afterwards",
        "{} startet mitten in seinem Block neu: der Block kommt danach an",
        restarted,
        LINK,
        SENDS,
        (GIVES, AGAIN, LOST),
    ),
    Row("ST_01", "blocks to and from {} in turn", "Blöcke an {} und von {} im Wechsel", alternately, LINK, SENDS, (TAKES, GIVES)),
    Row(FETCH, "serves a FETCH of {}", "bedient ein FETCH von {}", fetches, JOB, PASSIVE, (TAKES,), True),
    Row(
        "BV_12",
        "what {} writes it reads back",
        "was {} schreibt, liest es zurück",
        writes,
        JOB,
        (*PASSIVE, "write"),
        (FETCH,),
        True,
    ),
    Row(
        "BV_13",
        "takes the reaction of {} to its command",
        "nimmt die Reaktion von {} auf den eigenen Befehl",
        is_served,
        JOB,
        ACTIVE,
        (GIVES,),
        True,
    ),
    Row(
        "BI_11",
        "refuses {} a missing block and goes on serving",
        "verweigert {} einen fehlenden Baustein und bedient weiter",
        misses,
        JOB,
        PASSIVE,
        (FETCH,),
        True,
    ),
    Row(
        "BO_11",
        "serves {} while its own command waits for its reaction",
        "bedient {}, während sein eigener Befehl auf die Reaktion wartet",
        both_ask,
        JOB,
        (*PASSIVE, *ACTIVE),
        (FETCH, "BV_13"),
        True,
    ),
)


def _purpose(maker: str, row: Row) -> Purpose[LineTester]:
    profile = replace(PROFILES[maker])

    def body(t: LineTester) -> None:
        row.body(t, profile)

    own = [case_id(maker, name) for name in row.preamble]
    before = own if maker == REFERENCE else [*own, case_id(REFERENCE, row.name)]
    return Purpose(
        case_id(maker, row.name),
        "both",
        row.summary.replace("{}", maker),
        row.summary_de.replace("{}", maker),
        row.clause,
        body,
        cross_reference=profile.source,
        condition=row.condition,
        preamble=tuple(before),
    )


ALL = [_purpose(maker, row) for maker in MAKERS for row in ROWS if not row.rk512 or maker in WITH_RK512]
