"""Out of a recorded line a draft of its cell: [[line]], [[db]], per data word the type it looks like, period, range and evidence.

A recording shows how words change, not what they mean: `to =` and `from =` stay open, as comments, except for life words.  What a word
looks like is reported with its reasons; where two types fit, both are named (AX-205).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median

from gateway.pure.lines.decoder import LineReport, Telegram, telegram_of
from protocols.base.errors import DecodeError
from protocols.base.machine import Ns
from protocols.base.step5 import Step5Type, decode

FEW_BITS = 4  # bits of a word that change at once, at most, for it to be a row of bits
COUNTED = 0.8  # part of the steps that are +1 for a life word
MOST_WORDS = 256  # a cell's block has no more
LEAST = 4  # fewest samples for a statement about types
FLOAT = (1e-4, 1e7)  # magnitude of a believable float other than 0


@dataclass(slots=True)
class Job:
    """All telegrams of one kind to one place."""

    job: str
    db: int
    word: int
    words: int
    at: list[Ns] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    @property
    def period(self) -> Ns | None:
        """Median distance of two of them."""
        steps = [later - earlier for earlier, later in pairwise(self.at)]
        return round(median(steps)) if steps else None


@dataclass(frozen=True, slots=True)
class Guess:
    """What one data word looks like."""

    word: int
    kind: str  # bit KF KH KG REAL, or "" for a constant
    words: int
    evidence: str
    life: bool = False


@dataclass(slots=True)
class Learned:
    """Everything seen."""

    jobs: list[Job] = field(default_factory=list)
    active: str = ""  # side that sends the commands
    blocks: int = 0
    bad_checks: int = 0
    includes_stx: int = 0
    raw: list[bytes] = field(default_factory=list)  # blocks other than RK512
    conflicts: int = 0
    withdrew: str = ""  # side that answered DLE in a conflict
    repeats: int = 0
    reaction_times: list[Ns] = field(default_factory=list)
    flags: int = 0
    tests: int = 0  # blocks of axisgate's probe and diagnosis, which carry no information about the partner
    first: Ns = 0
    last: Ns = 0


TEST_BLOCKS = frozenset((b"UC", b"UV", b"UVW", b"U\x10V", b"U\x02\x02V", b"U\x15\x15V", b"U\x10AV", b"UAV"))
TEST_TEXT = b"U" + bytes(range(0x20, 0x7F)) * 43  # of any length
TEST_FETCH = bytes.fromhex("00004544FF000001FFFF")


def is_test(data: bytes) -> bool:
    """A block of `axisgate line probe` or `diagnose`: U and next to nothing, or the FETCH that any reaction will do for."""
    if data in TEST_BLOCKS or data == TEST_FETCH:
        return True
    if data[:1] != b"U":
        return False
    return len(data) <= 2 or TEST_TEXT.startswith(data)


def learn(reports: Iterable[LineReport]) -> Learned:
    """Sentences of a decoder that received both sides."""
    seen = Learned()
    waiting: tuple[LineReport, Telegram] | None = None
    for report in reports:
        seen.first, seen.last = seen.first or report.stamp, report.stamp
        seen.conflicts += "conflict" in report.text
        seen.repeats += report.kind == "NAK"
        if report.kind != "BLOCK":
            continue
        if is_test(report.data):
            seen.tests += 1
            continue
        seen.blocks += 1
        if not report.check_ok:
            seen.bad_checks += report.check_ok is False
            seen.includes_stx += report.check_difference == 2
            continue
        telegram = telegram_of(report.data)
        if telegram is None:
            seen.raw.append(report.data)
        elif telegram.job in ("SEND", "FETCH"):
            waiting, seen.active = (report, telegram), report.side
            seen.flags += report.data[8] != 0xFF
        elif telegram.job == "REACTION" and waiting is not None and report.side != waiting[0].side:
            seen.reaction_times.append(report.first - waiting[0].stamp)
            _job(seen, *waiting, telegram)
            waiting = None
    return seen


def _job(seen: Learned, report: LineReport, command: Telegram, reaction: Telegram) -> None:
    key = (command.job, command.db, command.word, command.amount)
    job = next((job for job in seen.jobs if (job.job, job.db, job.word, job.words) == key), None)
    if job is None:
        job = Job(*key)
        seen.jobs.append(job)
    job.at.append(report.first)
    job.numbers.append(reaction.number or 0)
    data = command.data if command.job == "SEND" else reaction.data
    if not reaction.number and len(data) == 2 * command.amount:
        job.data.append(data)


# ---- what a word looks like
def guesses(samples: Sequence[bytes], first_word: int) -> list[Guess]:
    """One guess for each word or pair of words; `samples`: the same words, one telegram after another."""
    found: list[Guess] = []
    words = min((len(sample) for sample in samples), default=0) // 2
    at = 0
    while at < words:
        guess = _pair(samples, at, first_word) if at + 1 < words else None
        guess = guess or _single([sample[2 * at : 2 * at + 2] for sample in samples], first_word + at)
        found.append(guess)
        at += guess.words
    return found


def _pair(samples: Sequence[bytes], at: int, first_word: int) -> Guess | None:
    """Two words that are one float: only where the lower one is too wild for a number of its own and every sample is believable."""
    pieces = [sample[2 * at : 2 * at + 4] for sample in samples]
    if len(set(pieces)) < LEAST or not _wild([piece[2:] for piece in pieces]):
        return None
    fits = [kind for kind in (Step5Type.REAL, Step5Type.KG) if all(_believable(kind, piece) for piece in pieces)]
    if not fits:
        return None
    values = [_number(fits[0], piece) for piece in pieces]
    names = " or ".join(kind.value for kind in fits)
    return Guess(
        first_word + at, fits[0].value, 2, f"{names}: {min(values):g}..{max(values):g}, {len(set(pieces))} values in {len(pieces)}"
    )


def _wild(words: Sequence[bytes]) -> bool:
    """Steps larger than a quarter of the range, often: the lower half of a mantissa."""
    numbers = [int.from_bytes(word, "big") for word in words]
    steps = [abs(later - earlier) for earlier, later in pairwise(numbers) if later != earlier]
    return len(steps) >= LEAST - 1 and sum(step > 0x2000 for step in steps) * 3 > len(steps)


def _believable(kind: Step5Type, piece: bytes) -> bool:
    try:
        value = abs(_number(kind, piece))
    except DecodeError:
        return False
    return value == 0 or FLOAT[0] <= value <= FLOAT[1]


def _number(kind: Step5Type, piece: bytes) -> float:
    value = decode(kind, piece)
    return float(value) if isinstance(value, int | float) else 0.0


def _single(words: Sequence[bytes], word: int) -> Guess:
    signed = [int.from_bytes(piece, "big", signed=True) for piece in words]
    different = sorted(set(signed))
    count = f"{len(different)} values in {len(words)} telegrams"
    if len(different) <= 1:
        return Guess(word, "", 1, f"constant {words[0].hex().upper()}h" if words else "never seen")
    changes = [(earlier, later) for earlier, later in pairwise(signed) if earlier != later]
    ones = sum((later - earlier) & 0xFFFF == 1 for earlier, later in changes)
    if len(words) >= LEAST and ones >= COUNTED * (len(words) - 1):
        return Guess(word, "KF", 1, f"counts up by 1 in {ones} of {len(words) - 1} telegrams: a life word", life=True)
    if _is_bits(changes):
        changed = 0
        for earlier, later in changes:
            changed |= (earlier ^ later) & 0xFFFF
        bits = ", ".join(str(bit) for bit in range(16) if changed >> bit & 1)
        return Guess(word, "bit", 1, f"bits {bits} change, never more than {FEW_BITS} at once; {count}")
    return Guess(word, "KF", 1, f"{different[0]}..{different[-1]} (KH {min(words).hex().upper()}..{max(words).hex().upper()}), {count}")


def _is_bits(changes: Sequence[tuple[int, int]]) -> bool:
    """Few bits change at once, half of the times a single one; a number that changes turns over more of them."""
    flips = [((earlier ^ later) & 0xFFFF) for earlier, later in changes]
    few = all(flip.bit_count() <= FEW_BITS for flip in flips)
    single = sum(flip.bit_count() == 1 for flip in flips) * 2 >= len(flips)
    return few and single


# ---- the draft
def draft(seen: Learned, source: str, baud: int, frame: str) -> str:
    """Return a cell file that `axisgate check` accepts, with its evidence as comments."""
    seconds = (seen.last - seen.first) / 1e9
    lines = [
        f"# Draft learned from {source}: {seen.blocks} blocks in {seconds:.1f} s.  Evidence: observed, meanings are not.",
        "# Fill in to = / from =, the units and the ranges, then: axisgate check FILE",
        "format = 1",
        "",
        "[cell]",
        'name   = "learned line"',
        'target = "simulation"                # "machine" asks for [safety] first',
        "",
        *_line(seen, baud, frame),
    ]
    for number, writer in sorted(_blocks(seen).items()):
        lines += ["", *_db(seen, number, writer)]
    return "\n".join(lines) + "\n"


def _line(seen: Learned, baud: int, frame: str) -> list[str]:
    layer = "rk512" if seen.jobs else "telegrams"
    times = f"reactions after {median(seen.reaction_times) / 1e6:.0f} ms" if seen.reaction_times else "no reaction seen"
    lines = [
        "[[line]]",
        'name     = "plc"',
        'port     = "sim"                     # the real one: "/dev/serial/by-id/..."',
        f'format   = "{baud} {frame}"           # as recorded',
        f'protocol = "3964R"                  # {seen.blocks - seen.bad_checks} of {seen.blocks} block checks right',
        'profile  = "siemens-cp525"           # not to be seen in good traffic: take the partner\'s (axisgate line diagnose)',
        f'priority = "low"                     # {_conflicts(seen)}',
        f'layer    = "{layer}"' + (f"                  # {times}, {seen.repeats} NAK" if seen.jobs else ""),
    ]
    if seen.jobs:
        lines.append(f'role     = "passive"                 # side {seen.active} sends the commands; we take the place of the other')
    life = next(
        (
            f"DB{db}.DW{guess.word}"
            for db, writer in sorted(_blocks(seen).items())
            if writer == "plc"
            for guess in _words(seen, db)
            if guess.life
        ),
        "",
    )
    if life:
        lines += ["", "[line.supervision]", f"max_silence_ms = {_silence(seen)}", f'life_word = "{life}"']
    if seen.includes_stx:
        lines.append(f"# {seen.includes_stx} block checks are off by 02h: that side includes STX")
    if seen.raw:
        lines.append(f"# {len(seen.raw)} blocks are not RK512, the first: {seen.raw[0][:24].hex(' ')}; describe them with [[telegram]]")
    if seen.tests:
        lines.append(f"# {seen.tests} test blocks of axisgate line probe or diagnose were left out")
    if seen.flags:
        lines.append(f"# {seen.flags} commands name a coordination flag")
    return lines


def _silence(seen: Learned) -> int:
    """Five missed telegrams, at least 1000 ms (users.md 3.3)."""
    periods = [job.period for job in seen.jobs if job.job == "SEND" and job.period]
    return max(1000, 5 * max(periods, default=0) // 1_000_000)


def _conflicts(seen: Learned) -> str:
    return f"{seen.conflicts} conflicts seen" if seen.conflicts else "no conflict seen: set opposite to the partner"


def _blocks(seen: Learned) -> dict[int, str]:
    """Data blocks -> who writes them."""
    writers: dict[int, str] = {}
    for job in seen.jobs:
        if any(number == 0 for number in job.numbers):
            writer = "plc" if job.job == "SEND" else "axisgate"
            writers[job.db] = "plc" if "plc" in (writer, writers.get(job.db)) else writer
    return writers


def _words(seen: Learned, db: int) -> list[Guess]:
    jobs = [job for job in seen.jobs if job.db == db and job.data]
    sends = [job for job in jobs if job.job == "SEND"] or jobs
    found: dict[int, Guess] = {}
    for job in sends:
        for guess in guesses(job.data, job.word):
            found.setdefault(guess.word, guess)
    return [found[word] for word in sorted(found)]


def _db(seen: Learned, number: int, writer: str) -> list[str]:
    jobs = [job for job in seen.jobs if job.db == number]
    taken = [job for job in jobs if any(number == 0 for number in job.numbers)]  # a refused job does not show the size
    words = min(MOST_WORDS, max(job.word + job.words for job in taken))
    lines = ["[[db]]", f"number  = {number}"]
    for job in jobs:
        period = f"every {job.period / 1e6:.0f} ms" if job.period else "once"
        refused = sum(number != 0 for number in job.numbers)
        lines.append(
            f"# {job.job} DW {job.word}, {job.words} words: {len(job.at)} times, {period}" + (f", {refused} refused" if refused else "")
        )
    lines += [f"words   = {words}", f'writer  = "{writer}"', 'line    = "plc"', "entries = ["]
    constants: list[int] = []
    for guess in _words(seen, number):
        if not guess.kind:
            constants.append(guess.word)
            continue
        lines.append(_entry(guess, writer))
    lines.append("]")
    if constants:
        lines.append(f"# constant all the time: DW {_ranges(constants)}")
    return lines


def _entry(guess: Guess, writer: str) -> str:
    if guess.life:
        name = "line.plc.life" if writer == "plc" else "cell.life"
        way = "to" if writer == "plc" else "from"
        return f'  {{ at = "DW {guess.word}", type = "KF", {way} = "{name}" }},  # {guess.evidence}'
    way = "to" if writer == "plc" else "from"
    place = {"bit": f"D {guess.word}.n"}.get(guess.kind, f"{'DD' if guess.words == 2 else 'DW'} {guess.word}")
    return f'  # {{ at = "{place}", type = "{guess.kind}", {way} = "...", unit = "..." }},  # {guess.evidence}'


def _ranges(words: Sequence[int]) -> str:
    """1, 2, 3, 7 as 1..3, 7."""
    parts: list[str] = []
    start = last = words[0]
    for word in [*words[1:], -1]:
        if word == last + 1:
            last = word
            continue
        parts.append(str(start) if start == last else f"{start}..{last}")
        start = last = word
    return ", ".join(parts)
