"""What a piece of a message is: counter, position, speed, torque-like, switch or a bit that follows the drive's switching on."""

import itertools
import operator
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gateway.pure.buses.inference.series import Cycles, Piece, Series, pieces

NATURAL = (8, 12, 16, 20, 24, 32)  # widths a designer chooses
STEADY = 0.9  # share of cycles with the same step: a counter
WAY = 500  # counts a position has to travel before we call it one
SMOOTH = 0.2  # largest change of the step, in steps
NEARLY_ALL, ALMOST_ALL = 0.97, 0.998  # the excluded share are jumps: switching on, lost frames, a power cycle
JUMP = 2.0  # times the fastest steady step
JOINED = 0.998  # bits of something else make it larger than 1
SPEED_FIT, TORQUE_FIT = 0.97, 0.5
FLAG_FLIPS = 40


@dataclass(frozen=True, slots=True)
class Found:
    """One signal of one message with how sure it is and why."""

    identifier: int
    name: str
    start: int
    bits: int
    signed: bool
    confidence: float  # 0..1
    why: str
    wraps: int = 0  # of a counter or position: how often it ran over its end


@dataclass(slots=True)
class Numbers:
    """What a piece looks like as a number."""

    series: Series
    piece: Piece
    values: list[int]
    signed: bool

    @property
    def steps(self) -> list[int]:
        return [b - a for a, b in zip(self.values, self.values[1:], strict=False)]


def numbers(series: Series) -> list[Numbers]:
    """All pieces with two bits and more, signed where their top bit looks like a sign; pieces of one number put together again."""
    joined: list[Piece] = []  # from the top down: the high bits show most of the way
    for below in reversed(pieces(series)):
        above = joined[-1] if joined else None
        if above is not None and below.start + below.bits == above.start and _one_number(series, below, above):
            joined[-1] = replace(above, start=below.start, bits=below.bits + above.bits, flips=below.flips)
        else:
            joined.append(below)
    return [_number(series, piece) for piece in reversed(joined) if piece.bits > 1]


def _number(series: Series, piece: Piece) -> Numbers:
    signed = piece.bits > 2 and _sign_like(series, piece)
    return Numbers(series, piece, series.values(piece.start, piece.bits, signed), signed)


def _sign_like(series: Series, piece: Piece) -> bool:
    """As a signed number it jumps less than as an unsigned one."""

    def rough(signed: bool) -> int:
        return sum(abs(b - a) for a, b in itertools.pairwise(series.values(piece.start, piece.bits, signed)))

    return rough(True) < rough(False)


def _one_number(series: Series, below: Piece, above: Piece) -> bool:
    """Return whether both pieces are one number: with its low bits the step of a moving number varies less than its high bits alone show
    (they count in multiples of 2^n).
    """
    if below.flips <= FLAG_FLIPS or above.bits < 3:
        return False
    high = _number(series, above)
    if counter(_number(series, below)) is not None or position(high) is None:
        return False
    whole = series.values(below.start, below.bits + above.bits, high.signed)
    alone, together = _unsteady(high.values, high.steps), _unsteady(whole, high.steps)
    return together < JOINED * (alone << below.bits)


def _unsteady(values: Sequence[int], moving: Sequence[int]) -> int:
    """Sum of the changes of the step while it moves."""
    changes = [abs(c - 2 * b + a) for a, b, c in zip(values, values[1:], values[2:], strict=False)]
    cap = sorted(changes)[int(ALMOST_ALL * (len(changes) - 1))]
    return sum(min(change, cap) for change, first, second in zip(changes, moving, moving[1:], strict=False) if first or second)


def quiet(steps: Sequence[int]) -> list[int]:
    """The steps without the few jumps of a counter that began anew (power cycle, wrap)."""
    limit = _fastest(steps)
    return [step if abs(step) <= limit else 0 for step in steps]


def unwrapped(number: Numbers) -> tuple[list[int], int]:
    """Return the steps within the number's width and the number of overflows; jumps other than overflows stay 0."""
    size = 1 << number.piece.bits
    limit = _fastest(number.steps)
    found, wraps = [], 0
    for step in number.steps:
        folded = (step + size // 2) % size - size // 2
        wrapped = abs(step) > limit and abs(folded) <= limit
        wraps += wrapped
        found.append(folded if wrapped else step if abs(step) <= limit else 0)
    return found, wraps


def _fastest(steps: Sequence[int]) -> float:
    return JUMP * sorted(map(abs, steps))[int(ALMOST_ALL * (len(steps) - 1))]


def _wraps(count: int) -> str:
    return f", {count} wrap{'s' if count != 1 else ''}" if count else ""


def counter(number: Numbers) -> Found | None:
    """The same step every cycle, modulo its width."""
    size = 1 << number.piece.bits
    steps = [step % size for step in number.steps]
    usual = max(set(steps), key=steps.count)
    share = steps.count(usual) / len(steps)
    if not usual or share < STEADY:
        return None
    piece = number.piece
    down = 2 * usual > size  # +255 of 8 bits counts backwards
    whole = number.series.values(piece.start, piece.bits, False)
    wraps = sum((b > a) if down else (b < a) for a, b in itertools.pairwise(whole) if (b - a) % size == usual)
    note = f"{usual - size if down else usual:+} in {100 * share:.1f} % of the cycles{_wraps(wraps)}"
    return Found(number.series.identifier, "life", piece.start, piece.bits, False, share, note, wraps)


def position(number: Numbers) -> Found | None:
    """Travels far in small steps whose change is smaller still: it integrates to a speed."""
    (steps, wraps), piece = unwrapped(number), number.piece
    places = list(itertools.accumulate(steps, initial=number.values[0])) if wraps else number.values
    way, fastest = max(places) - min(places), max(map(abs, steps))
    if way < WAY or fastest == 0 or fastest > way / 8:
        return None
    changes = sorted(abs(b - a) for a, b in itertools.pairwise(steps) if a or b)
    rough = changes[int(NEARLY_ALL * len(changes))] / fastest  # ignores a few jumps, as at switching on
    if rough > SMOOTH:
        return None
    bits, note = _width(number)
    why = f"way {way}, fastest {fastest} a cycle, change of the step at most {100 * rough:.0f} % of it{_wraps(wraps)}{note}"
    return Found(number.series.identifier, "position_inc", piece.start, bits, True, min(0.98, 1.0 - rough), why, wraps)


def _width(number: Numbers) -> tuple[int, str]:
    """A number that was negative once showed all its bits; else those above that never change belong to it up to a usual width."""
    piece = number.piece
    if number.signed and min(number.values) < 0:
        return piece.bits, ""
    room = piece.top - piece.start
    wide = next((bits for bits in reversed(NATURAL) if piece.bits <= bits <= room), piece.bits)
    idle = wide - piece.bits
    return wide, f"; its upper {idle} bits never changed, the width is assumed" if idle else ""


def correlation(a: Sequence[float], b: Sequence[float]) -> float:
    """Return the correlation, -1..1; 0 where one of them is constant."""
    n = len(a)
    mean_a, mean_b = sum(a) / n, sum(b) / n
    both = sum(map(operator.mul, a, b)) / n - mean_a * mean_b
    spread = (sum(map(operator.mul, a, a)) / n - mean_a**2) * (sum(map(operator.mul, b, b)) / n - mean_b**2)
    return both / spread**0.5 if spread > 0.0 else 0.0


def speed(number: Numbers, way: Sequence[int]) -> Found | None:
    """Find a number that follows the step of the position in the same message, or one to three cycles off."""
    steps = quiet([b - a for a, b in itertools.pairwise(way)])
    best = 0.0
    for shift in range(-3, 4):
        low, high = max(0, shift), min(len(steps), len(steps) + shift)
        ours = number.values[1:][low:high]
        best = max(best, abs(correlation(ours, steps[low - shift : high - shift])))
    if best < SPEED_FIT:
        return None
    bits, note = _width(number)
    why = f"correlation with the position's step {best:.3f}{note}"
    return Found(number.series.identifier, "speed_rpm", number.piece.start, bits, True, best, why)


def torque(number: Numbers, way: Sequence[int]) -> Found | None:
    """Neither position nor speed, but runs with acceleration and the direction of the speed (friction)."""
    steps = [float(step) for step in quiet([b - a for a, b in itertools.pairwise(way)])]
    push = [b - a for a, b in itertools.pairwise(steps)]
    push = _smoothed(push, 5)
    sign = [float((step > 0) - (step < 0)) for step in _smoothed(steps, 3)[1:]]
    ours = _smoothed([float(value) for value in number.values[2:]], 5)
    best, what = 0.0, ""
    for shift in range(-3, 4):
        a, b, c = _shifted(ours, push, shift), _shifted(ours, sign, shift), _shifted(push, sign, 0)
        r = _two_fit(correlation(*a), correlation(*b), correlation(*c))
        if r > best:
            best, what = r, f"fit with acceleration and direction {r:.2f}"
    if best < TORQUE_FIT:
        return None
    bits, note = _width(number)
    return Found(number.series.identifier, "torque_permille", number.piece.start, bits, True, min(0.9, best), what + note)


def _two_fit(ra: float, rb: float, rab: float) -> float:
    """Multiple correlation with two causes."""
    left = 1.0 - rab * rab
    return 0.0 if left < 1e-9 else max(0.0, (ra * ra + rb * rb - 2 * ra * rb * rab) / left) ** 0.5


def _shifted(a: Sequence[float], b: Sequence[float], shift: int) -> tuple[Sequence[float], Sequence[float]]:
    size = min(len(a), len(b)) - abs(shift)
    first, second = max(0, shift), max(0, -shift)
    return a[first : first + size], b[second : second + size]


def _smoothed(values: Sequence[float], size: int) -> list[float]:
    """Mean over `size` neighbours."""
    half, out, total = size // 2, list[float](), 0.0
    padded = [values[0]] * half + list(values) + [values[-1]] * half
    for n, value in enumerate(padded):
        total += value
        if n >= size:
            total -= padded[n - size]
        if n >= size - 1:
            out.append(total / size)
    return out


def place_of(whole: Sequence[Numbers]) -> Found | None:
    """The position of a message: of all that could be one that which travels furthest."""
    best: tuple[float, Found] | None = None
    for number in whole:
        found = position(number)
        way = max(number.values) - min(number.values)
        if found is not None and (best is None or found.confidence * way > best[0]):
            best = found.confidence * way, found
    return best[1] if best else None


def of_message(series: Series) -> list[Found]:
    """Counters, positions, speeds and torque-like numbers of one message, and the rest of its numbers without a name."""
    whole, out = numbers(series), list[Found]()
    place = place_of(whole)
    way = series.values(place.start, place.bits, True) if place else []
    for number in whole:
        if place is not None and number.piece.start == place.start:
            out.append(place)
            continue
        named = counter(number)
        if named is None and way:
            named = speed(number, way) or torque(number, way)
        if named is None and number.piece.flips > FLAG_FLIPS:
            text = f"{len(set(number.values))} different values"
            named = Found(
                series.identifier, f"number_{number.piece.start}", number.piece.start, number.piece.bits, number.signed, 0.2, text
            )
        if named is not None:
            out.append(named)
    return out


def flag_bits(series: Series, taken: Sequence[Found]) -> list[int]:
    """Bits that changed seldom and belong to no number."""
    covered = {bit for each in taken for bit in range(each.start, each.start + each.bits)}
    return [bit for bit in range(8 * series.length) if bit not in covered and 0 < len(series.flips(bit)) <= FLAG_FLIPS]


def steady_bits(series: Series, taken: Sequence[Found]) -> list[int]:
    """Bits that were 1 all the time."""
    covered = {bit for each in taken for bit in range(each.start, each.start + each.bits)}
    every = ~0
    for word in series.words:
        every &= word
    return [bit for bit in range(8 * series.length) if bit not in covered and every >> bit & 1]


def without_torque(found: Sequence[Found]) -> list[Found]:
    """A set value carries no torque: what looks like one is an unidentified number."""
    return [
        replace(each, name=f"number_{each.start}", confidence=0.2, why=f"runs with the motion, meaning unknown ({each.why})")
        if each.name == "torque_permille"
        else each
        for each in found
    ]


def explained(cycles: Cycles) -> float:
    """How much of a recording makes sense: bits of counters and positions, for the choice of the byte order."""
    total = 0.0
    for series in cycles.messages:
        whole = numbers(series)
        sure = [place_of(whole), *(counter(number) for number in whole)]
        total += sum(each.bits * each.confidence for each in sure if each is not None)
    return total
