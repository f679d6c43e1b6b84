"""What `line diagnose` concludes from its observations: pure, so that every wording is tested with a partner that has the fault.

Sources: serial-protocols 1 and 2; users.md (open line with cross-talk, 16 ms latency timer, equal priorities); AX-204.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

from gateway.pure.lines.texts import said
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char

Heard = int | Damage
LATENCY_GOOD_MS = 1
SLOW_ANSWER = (ms(12), ms(40))  # answers of an adapter whose latency timer is set to 16 ms
ECHO_WHOLE = 0.95  # part of the pattern that must come back for an echo


@dataclass(frozen=True, slots=True)
class Finding:
    """One conclusion: short name, level (fault | warn | ok | note), what, what to do."""

    name: str
    level: str
    text: str
    todo: str = ""


@dataclass(slots=True)
class Evidence:
    """What was seen, in the order in which it was looked for.  None: not looked for, or could not be."""

    our_format: str = "9600 8E1"
    our_priority: str = "low"
    idle: list[Heard] = field(default_factory=list)  # while axisgate was silent
    pattern: bytes = b""  # sent into the idle line
    returned: list[Heard] = field(default_factory=list)  # and what came
    answers: dict[str, list[Heard]] = field(default_factory=dict)  # line format -> what came after STX
    late: Heard | None = None  # what came after the acknowledgement delay, at our format
    late_after: Ns = 0  # after our STX
    answer_times: list[Ns] = field(default_factory=list)  # STX to DLE at our format
    latency_timer_ms: int | None = None  # reported by the system for the adapter
    latency_file: str = ""
    hidden_adapter: bool = True  # there may be a USB adapter whose latency timer the system does not show
    checks: dict[str, Heard | None] = field(default_factory=dict)  # check we sent (right, stx, once, none) -> answer to the block
    their_difference: int | None = None  # their BCC xor the right one
    reaction: bytes | None = None  # to a FETCH; b"": no reaction
    spoilt: str = ""  # what was wrong with the reaction
    blocks: list[bytes] = field(default_factory=list)  # sent unasked by the partner; they were acknowledged
    conflict: Heard | None | str = "not tried"  # what came after our STX met theirs


def judge(seen: Evidence) -> list[Finding]:
    """The findings, the one that hides all others first."""
    line = _idle(seen) + _echo(seen)
    if any(finding.level == "fault" for finding in line):
        return line
    partner = _partner(seen)
    if any(finding.level == "fault" for finding in partner):
        return line + partner
    checks = _checks(seen)
    rides = [one for one in _rides(seen) if one.name != "reaction spoilt" or not checks]  # a wrong check spoils the reaction as well
    return line + partner + _latency(seen) + checks + rides + _priority(seen)


# ---- the line itself
def _idle(seen: Evidence) -> list[Finding]:
    breaks = sum(what in (Damage.BREAK, Damage.FRAMING) or what == 0 for what in seen.idle)
    if breaks and breaks == len(seen.idle):
        text = said("the idle line reads as BREAK or framing errors ({} of them): its polarity is the wrong way round", breaks)
        return [
            Finding("wires crossed", "fault", text, "exchange the two wires of the receiving pair (A and B, or + and -; TTY: RX+ and RX-)")
        ]
    if seen.blocks:
        text = said("blocks that the partner sent unprompted were acknowledged and not used: {}", len(seen.blocks))
        return [Finding("line in use", "note", text, "nothing; stop its program where the blocks must not get lost")]
    if seen.idle:
        text = said("{} characters were received while this side was silent", len(seen.idle))
        return [Finding("line in use", "note", text, "is a third station on the line, or does the partner send unprompted?")]
    return []


def _echo(seen: Evidence) -> list[Finding]:
    if not seen.pattern:
        return []
    came = [what for what in seen.returned if what not in (Char.NAK, Char.STX)]
    same = len(matches(seen.pattern, came))
    if same >= ECHO_WHOLE * len(seen.pattern):
        text = said("every character is returned ({} of {}): an echo", same, len(seen.pattern))
        todo = "switch the echo of the 2-wire adapter off, or remove the loop-back plug; 3964R needs both directions apart"
        return [Finding("echo", "fault", text, todo)]
    damaged = sum(isinstance(what, Damage) for what in came)
    if came and not same and not damaged:
        level = "note" if _good(seen.answers.get(seen.our_format, [])) else "fault"
        text = said("{} characters without a meaning were answered with others: {}", len(seen.pattern), _shown(came))
        return [Finding("other characters", level, text, "another protocol or speed at the partner, or cross-talk on an open line")]
    if came:
        text = said(
            "of {} characters {} were returned correctly and {} damaged: cross-talk on an open line, not an echo",
            len(seen.pattern),
            same,
            damaged,
        )
        return [
            Finding(
                "cross-talk", "fault", text, "the receiving pair is open: partner off, plug out, wire broken, or TTY loop without current"
            )
        ]
    return []


def matches(pattern: bytes, came: Sequence[Heard]) -> list[int]:
    """Characters of the pattern that came back, in its order."""
    found, at = [], 0
    for what in came:
        place = pattern.find(what, at) if isinstance(what, int) else -1
        if place >= 0:
            found.append(place)
            at = place + 1
    return found


# ---- does somebody answer
def _good(heard: Sequence[Heard]) -> bool:
    return bool(heard) and heard[0] == Char.DLE


def _partner(seen: Evidence) -> list[Finding]:
    ours = seen.answers.get(seen.our_format, [])
    if _good(ours):
        return [Finding("3964R", "ok", said("STX is answered with DLE at {}", seen.our_format))]
    others = [name for name, heard in seen.answers.items() if name != seen.our_format and _good(heard)]
    if others:
        return [_wrong_format(seen.our_format, others[0])]
    if ours and ours[0] == Char.NAK:
        return [
            Finding(
                "not ready",
                "fault",
                "STX is answered with NAK: the partner is present but accepts no block",
                "its buffer is full or its program is in STOP",
            )
        ]
    if any(seen.answers.values()):
        heard = "; ".join(f"{name}: {_shown(what)}" for name, what in seen.answers.items() if what)
        text = said("something answers, but no DLE: {}", heard)
        return [Finding("no 3964R", "fault", text, "is this the right port, and does the partner speak 3964 or 3964R at all?")]
    if seen.late is not None:
        return [_slow(seen.late, seen.late_after)]
    text = said("nothing answers at {}", ", ".join(seen.answers) or seen.our_format)
    todo = "partner off or its interface not started; TXD and RXD exchanged (cross pins 2 and 3, or TTY sender and receiver); cable"
    return [Finding("partner silent", "fault", text, todo)]


def _slow(what: Heard, after: Ns) -> Finding:
    named = "DLE" if what == Char.DLE else _shown([what])
    text = said("STX is answered with {} after {:.1f} s: later than the acknowledgement delay allows", named, after / 1e9)
    todo = "the partner is present but slow: a busy program, or a converter in between; a longer QVZ (ack_delay) on our side allows for it"
    return Finding("partner slow", "fault", text, todo)


def _wrong_format(ours: str, theirs: str) -> Finding:
    baud, other = ours.split(maxsplit=1)[0], theirs.split(maxsplit=1)[0]
    what = "wrong speed" if baud != other else "wrong parity or frame"
    return Finding(what, "fault", said("the partner answers at {}, not at {}", theirs, ours), said('set format = "{}"', theirs))


def _shown(heard: Sequence[Heard]) -> str:
    return " ".join(f"{what:02X}" if isinstance(what, int) else what.name.lower() for what in heard[:8])


def _latency(seen: Evidence) -> list[Finding]:
    found = []
    if seen.latency_timer_ms is not None and seen.latency_timer_ms > LATENCY_GOOD_MS:
        text = said(
            "the latency timer of the USB adapter is set to {} ms: each answer can wait that long in the adapter", seen.latency_timer_ms
        )
        found.append(Finding("USB latency timer", "warn", text, said("echo {} | sudo tee {}", LATENCY_GOOD_MS, seen.latency_file)))
    elif seen.answer_times and SLOW_ANSWER[0] <= median(seen.answer_times) <= SLOW_ANSWER[1] and not seen.hidden_adapter:
        text = said("answers take {:.0f} ms: the partner polls its line", median(seen.answer_times) / 1e6)
        found.append(Finding("slow answers", "note", text, "nothing, while they stay far below QVZ/ADT"))
    elif seen.answer_times and SLOW_ANSWER[0] <= median(seen.answer_times) <= SLOW_ANSWER[1]:
        text = said("answers take {:.0f} ms, as through a USB adapter whose latency timer is set to 16 ms", median(seen.answer_times) / 1e6)
        found.append(
            Finding(
                "USB latency timer",
                "warn",
                text,
                "set the adapter's latency timer to 1 ms (Linux: latency_timer in sysfs; Windows: port settings)",
            )
        )
    return found


SET_OURS = {
    "high": 'set this side to priority = "low"',
    "low": 'set this side to priority = "high"',
}  # theirs -> what to write into the cell


# ---- the block check
def _checks(seen: Evidence) -> list[Finding]:
    if seen.their_difference == Char.STX or (seen.checks.get("right") == Char.NAK and seen.checks.get("stx") == Char.DLE):
        text = "BCC off by 02h: the partner begins the exclusive or with STX"
        return [Finding("BCC off by 02h", "fault", text, "the partner's software is wrong; STX is not part of the block check")]
    if seen.checks.get("dle right") == Char.NAK and seen.checks.get("dle once") == Char.DLE:
        text = "the partner counts a doubled 10h once: blocks with an odd number of 10h are refused both ways"
        return [
            Finding(
                "BCC counts 10h once", "fault", text, "the partner's software is wrong; both characters of a doubled DLE are in the check"
            )
        ]
    if seen.checks.get("none") == Char.DLE:
        refused = seen.checks.get("right") == Char.NAK
        text = "blocks without check are taken, with check refused" if refused else "blocks are taken without their check"
        todo = 'set both to 3964R (or protocol = "3964")'
        return [Finding("3964 without R", "fault", said("{}: the partner is set to 3964", text), todo)]
    if seen.checks.get("right") == Char.NAK:
        return [Finding("blocks refused", "fault", "a good block is refused with every check tried", "parity, or another block format")]
    return []


# ---- what rides on it
def _rides(seen: Evidence) -> list[Finding]:
    if seen.spoilt:
        spoilt = said("the reaction to a FETCH is no good block: {}", seen.spoilt)
        return [Finding("reaction spoilt", "fault", spoilt, "parity, speed, or the partner's software")]
    if seen.reaction or any(_is_rk512(block) for block in seen.blocks):
        number = said(", it answered {:02X}h", seen.reaction[3]) if seen.reaction and len(seen.reaction) >= 4 else ""
        return [Finding("RK512", "ok", said("RK512 runs on 3964R{}", number), 'layer = "rk512"')]
    if seen.reaction == b"" or seen.blocks:
        text = "a FETCH was acknowledged but brought no reaction telegram: raw 3964R blocks, no RK512 (or an active station only)"
        return [Finding("raw 3964R", "ok", text, 'layer = "telegrams"; describe the blocks with [[telegram]]')]
    return []


def _is_rk512(block: bytes) -> bool:
    command = len(block) >= 10 and block[0] in (0, 0xFF) and block[1] == 0 and block[2] in b"AOE"
    return command or (len(block) >= 4 and block[0] in (0, 0xFF) and block[1:3] == b"\0\0")


def _priority(seen: Evidence) -> list[Finding]:
    if seen.conflict == "not tried":
        return []
    if seen.conflict == Char.NAK:
        return [
            Finding(
                "refuses conflicts",
                "warn",
                "the partner answers a conflicting STX with NAK",
                "avoid sending at once; leave sending to one side",
            )
        ]
    theirs = "low" if seen.conflict == Char.DLE else "high"
    if theirs != seen.our_priority:
        return [Finding("priority", "ok", said("the partner has priority {}, this side {}", theirs, seen.our_priority))]
    text = said("both stations have the same priority ({}): whenever both send at once, both jobs wait or fail", theirs)
    return [Finding("same priority", "fault", text, SET_OURS[theirs])]


# ---- what the partner shows
PAFE = {
    0x0: "no error",
    0x1: "wrong ORG format, or type of source or destination not allowed",
    0x2: "area does not exist (data block missing or not allowed)",
    0x3: "area too short",
    0x4: "QVZ: no access possible (acknowledgement delay of the memory or interface)",
    0x5: "status word (ANZW) wrong",
    0x6: "no source or destination parameters for SEND ALL / RECEIVE ALL",
    0x7: "interface does not exist (SSNR)",
    0x8: "interface not ready: CP not synchronised, or in STOP",
    0x9: "interface overloaded",
    0xA: "interface busy with another job",
    0xB: "job number (ANR) not allowed",
    0xC: "interface (CP) does not acknowledge, or negatively",
    0xD: "parameter BLGR (block size) not allowed",
    0xE: "fault in the handling block",
    0xF: "handling block called twice or not allowed here",
}
ANZW_BITS = {
    0: "receive possible (handshake makes sense)",
    1: "job runs",
    2: "job ended without error",
    3: "job ended with error",
    4: "data transfer runs",
    5: "data handed to the CP",
    6: "data taken from the CP",
    7: "data block locked",
}
ANZW_ERRORS = {**{number: PAFE[number] for number in (1, 2, 3, 4, 5)}, 0: "the CP has set the job up again after a restart"}
CP341_CLASSES: Mapping[int, str] = {
    0: "start of the CP",
    1: "hardware fault of the CP",
    2: "fault at initialisation: parameters missing or wrong",
    3: "parameters of the function blocks wrong",
    4: "fault in the traffic between CP and CPU",
    5: "fault in a job of the own CPU",
    6: "fault in a job of the partner (RK512): what we sent was refused",
    7: "send fault",
    8: "receive fault",
    9: "the partner's reaction carried an error number (RK512)",
    10: "fault in the partner's reaction, seen by the CP (RK512)",
    14: "fault of a loaded driver",
    30: "fault between function block and CP",
}
CP341_EVENTS: Mapping[tuple[int, int], str] = {
    (6, 0x01): "byte 1 of the command is neither 00 nor FF",
    (6, 0x02): "byte 3 is not one of A, O, E",
    (6, 0x04): "byte 4 (type) wrong or not allowed at the CP",
    (6, 0x06): "byte 5: data block number not allowed",
    (6, 0x07): "bytes 5/6: start address too high",
    (6, 0x08): "bytes 7/8: amount not allowed",
    (6, 0x0E): "sequence; normal after a restart of either side",
    (6, 0x0F): "data block locked by the coordination flag",
    (6, 0x10): "telegram too short: below 10 bytes, follow-on and reaction below 4",
    (6, 0x11): "length in the header and bytes received differ",
    (7, 0x01): "first repeat: the partner answered the block with NAK, or a fault was seen",
    (7, 0x02): "STX was answered with NAK or a character that is neither DLE nor STX",
    (7, 0x03): "STX was not answered within QVZ/ADT",
    (7, 0x04): "the partner aborted: a character was received while the block was sent",
    (7, 0x06): "the block was answered with NAK or a character other than DLE",
    (7, 0x07): "the block was not answered within QVZ/ADT",
    (7, 0x09): "no connection: all connection attempts used up",
    (7, 0x0A): "not sent: all block attempts used up",
    (7, 0x0B): "conflict that cannot be settled: both stations have priority high",
    (7, 0x0C): "conflict that cannot be settled: both stations have priority low",
    (
        8,
        0x02,
    ): "a character other than NAK or STX was received in idle, or characters after STX before DLE; normal when the partner is switched on",
    (8, 0x05): "DLE was followed by neither DLE nor ETX",
    (8, 0x06): "ZVZ/CDT exceeded",
    (8, 0x08): "block check (BCC) wrong",
    (8, 0x09): "no repeat within the block wait time (BWZ)",
    (8, 0x0C): "parity, framing or overrun error",
    (8, 0x0D): "BREAK: the line to the partner is open",
    (9, 0x08): "the partner reports a wrong sequence; normal after a restart of either side",
    (9, 0x09): "the partner's block is locked by a coordination flag",
    (9, 0x0A): "the partner reports: byte 3 of the command wrong",
    (9, 0x0B): "the partner reports: byte 1 or 4 of the command wrong",
    (9, 0x0C): "the partner reports: length wrong",
    (9, 0x0D): "the partner has not been restarted yet",
    (10, 0x01): "reaction without a request, or in the wrong sequence; normal after a restart of either side",
    (10, 0x02): "byte 1 of the reaction is neither 00 nor FF",
    (10, 0x03): "the reaction has too much or too little data",
    (10, 0x04): "the reaction to a SEND has data",
    (10, 0x05): "no reaction within the monitoring time (BWZ)",
}
NORMAL_AT_START = ((6, 0x0E), (8, 0x02), (9, 0x08), (9, 0x0D), (10, 0x01))


def pafe(value: int) -> Finding:
    """The PAFE byte of an S5 handling block in words."""
    if not value & 1:
        return Finding(said("PAFE {:02X}h", value), "ok", "no parameter error")
    return Finding(said("PAFE {:02X}h", value), "fault", PAFE[value >> 4 & 0x0F], "the parameters of the handling block, not the line")


def anzw(value: int) -> list[Finding]:
    """The ANZW (status word) of a job in an S5, bit by bit; its error number belongs to bit 3."""
    found = [
        Finding(said("ANZW bit {}", bit), "fault" if bit == 3 else "note", text) for bit, text in ANZW_BITS.items() if value >> bit & 1
    ]
    number = value >> 8 & 0x0F
    if value >> 3 & 1:
        text = ANZW_ERRORS.get(
            number, said("error of the CP, number {:X}h: its manual names it; on 3964R mostly no connection or a negative reaction", number)
        )
        found.append(Finding(said("ANZW error {:X}h", number), "fault", text))
    return found or [Finding(said("ANZW {:04X}h", value), "note", "no bit is set: the job was never started")]


def cp341(event_class: int, number: int) -> Finding:
    """An event class and number of a CP 340, 341 or 440 in words; normal start-up events are named and no fault."""
    name = said("({:02X}){:02X}h", event_class, number)
    group = CP341_CLASSES.get(event_class)
    if group is None:
        return Finding(name, "note", said("class {} is not in the table; known: {}", event_class, ", ".join(map(str, CP341_CLASSES))))
    text = CP341_EVENTS.get((event_class, number), "this number is not in our table; the CP's manual names it")
    return Finding(name, "note" if (event_class, number) in NORMAL_AT_START else "fault", said("{}: {}", group, text))
