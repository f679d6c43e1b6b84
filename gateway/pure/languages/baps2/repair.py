"""One sign or name that is missing, written twice or exchanged with its neighbour causes several faults: the slip is undone, and the
program is read again.

AX-1822.
"""

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

from gateway.pure.languages.baps2.declarations import STARTERS
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.mistakes import CLOSERS, WITH_OPERAND
from gateway.pure.languages.baps2.type_names import KINEMATIC
from gateway.pure.languages.base.faults import Faults, Severity
from gateway.pure.languages.base.source import Position, base_name

MOST_TOKENS = 15_000  # that are read again in all
MOST_REPAIRS = 3  # of one program
MOST_NAMES = 4  # that are tried in one place
MOST_GAPS = 12  # between which a bracket may be missing
MOST_OPEN = 8  # opening brackets of one statement that are looked at, the innermost
MOST_BEHIND = 200  # tokens after an opening bracket
NEAR = 5  # of the middle of a pair from a fault, in half tokens
MOST_PLACES = 1_000  # of one kind that are compared
PAIRS = {")": "(", "]": "["}
CLOSING = {"(": ")", "[": "]"}
STATEMENTS = (CLOSERS | WITH_OPERAND | {"BEGIN", "PARALLEL", "HALT", "BREAK", "SPC_FCT", "CONST"}) - {"STOP", "START"}
BEHIND = ("TO", "VIA", "THEN", "AND", "OR", "MAX_TIME", "ERROR", "TIMES", "EQUAL")  # the content of brackets ends before these
OPERANDS = (Kind.NAME, Kind.NUMBER, Kind.TEXT)
BEGINS = ("BEGIN", "START")
SIGNS = (".", "=", ",", ":")  # that are put between two operands
NAMED_BY = ("PROGRAM", "SUBROUTINE")  # a name follows
_NUMBERED = re.compile(r"\d\s*=\s*([^\W\d]\w*)")
_NAME = re.compile(r"@?[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class Repair:
    """A token that is missing, is written twice (drop) or is exchanged with the next one (swap).

    `place`: its index, with those of the repairs before it in the text.
    """

    place: int
    token: Token
    text: str
    hint: str = ""
    drop: bool = False
    more: tuple[Token, ...] = ()  # that follow it
    swap: bool = False
    id: str = "syntax"
    at: Position | None = None  # where it is reported, if not at its own place

    @property
    def position(self) -> Position:
        """Where it is reported."""
        return self.at or self.token.position

    def apply(self, tokens: list[Token]) -> None:
        """Puts the token in its place, or leaves it out."""
        if self.drop:
            del tokens[self.place]
        elif self.swap:
            tokens[self.place : self.place + 2] = tokens[self.place : self.place + 2][::-1]
        else:
            tokens[self.place : self.place] = [self.token, *self.more]


Trial = Callable[[Sequence[Repair]], Faults]  # the faults of the program with these repairs
Finder = Callable[[Sequence[Token], Faults], Iterator[Repair]]


def repairs_of(tokens: list[Token], trial: Trial, others: Sequence[Finder]) -> tuple[Repair, ...]:
    """The repairs that leave the fewest errors, each of which counts as one; () where none helps.  `tokens`: all of the program;
    `others`: find more of them.
    """
    chosen: tuple[Repair, ...] = ()
    faults = trial(())
    left = MOST_TOKENS // len(tokens)  # trials
    while left and faults.errors > len(chosen) + 1 and len(chosen) < MOST_REPAIRS:
        best: Repair | None = None
        fewest = faults.errors
        kinds = (_doubled, _brackets, _names, _exchanged, _signs, _labels, *others)
        places = [each for kind in kinds for each in islice(kind(tokens, faults), MOST_PLACES)]
        for each in _nearest(places, faults)[:left]:
            left -= 1
            left_over = trial((*chosen, each))
            errors = left_over.errors
            if errors < fewest and not (each.swap and _errors_in(left_over, each.position) > 1):
                best, fewest = each, errors
            if fewest <= len(chosen) + 1:
                break
        if best is None:
            break
        best.apply(tokens)
        chosen = (*chosen, best)
        faults = trial(chosen)
    return chosen


def _errors_in(faults: Faults, at: Position) -> int:
    """The errors in a line."""
    return sum(each.severity is Severity.ERROR and each.position[:2] == at[:2] for each in faults)


def _nearest(repairs: Sequence[Repair], faults: Faults) -> list[Repair]:
    """Those nearest to an error first."""
    lines = {each.position.line for each in faults if each.severity is Severity.ERROR}
    return sorted(repairs, key=lambda each: min(abs(each.position.line - line) for line in lines))


# ---- what is written twice


def _doubled(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Tokens that follow themselves, in lines with a fault."""
    lines = {each.position[:2] for each in faults if each.severity is Severity.ERROR}
    for place in range(1, len(tokens)):
        before, token = tokens[place - 1], tokens[place]
        same = (token.kind, token.key) == (before.kind, before.key) and token.position[:2] == before.position[:2]
        if same and token.position[:2] in lines:
            yield Repair(place, token, f"{token} is written twice", drop=True)


# ---- what is exchanged


def _exchanged(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Neighbours in the line of a fault and near it, the nearest first."""
    columns: dict[tuple[str, int], list[int]] = {}
    for each in faults:
        if each.severity is Severity.ERROR:
            columns.setdefault(each.position[:2], []).append(each.position.column)
    kinematics = {name.upper() for name in _named_kinematics(tokens)}
    found: list[tuple[int, int]] = []
    for at, end in _lines(tokens, columns):
        faulty = {
            min(range(at, end), key=lambda place: abs(tokens[place].position.column - column))
            for column in columns[tokens[at].position[:2]]
        }
        found += [(min(_far(place, fault) for fault in faulty), place) for place in range(at, end - 1)]
    for far, place in sorted(found):
        first, second = tokens[place : place + 2]
        if far <= NEAR and _may_be_exchanged(first, second) and not _lists(tokens, place, kinematics):
            yield Repair(place, first, f"{first} and {second} are exchanged", f"write {second.text} {first.text}", swap=True)


def _may_be_exchanged(first: Token, second: Token) -> bool:
    """Not two operands, between which something is missing, and not `:=`."""
    operands = all(each.kind in OPERANDS and not each.word for each in (first, second))
    literal = Kind.NAME not in (first.kind, second.kind) or Kind.TEXT in (first.kind, second.kind)
    other = Kind.INSTRUCTION in (first.kind, second.kind) or (first.text, second.text) == (":", "=")
    return first.key != second.key and not other and not (operands and literal)


def _lists(tokens: Sequence[Token], place: int, kinematics: Collection[str]) -> bool:
    """Whether these are TO or VIA and the first of two points, between which something is missing."""
    before, second = tokens[place - 1], tokens[place + 1]
    behind = tokens[min(place + 2, len(tokens) - 1)]
    points = second.kind is behind.kind is Kind.NAME and not behind.word and before.kind is Kind.NAME
    return tokens[place].word in ("TO", "VIA") and points and second.key not in kinematics


def _lines(tokens: Sequence[Token], wanted: Collection[tuple[str, int]]) -> Iterator[tuple[int, int]]:
    """The first index and the one behind the last of each line that is wanted."""
    at = 0
    for place in range(1, len(tokens)):
        if tokens[place].position[:2] != tokens[at].position[:2]:
            if tokens[at].position[:2] in wanted:
                yield at, place
            at = place


def _far(place: int, fault: int) -> int:
    """How far the pair that begins at `place` is from the token with the fault, which is its second one as a rule."""
    return abs(2 * (fault - place) - 1)


# ---- brackets


def _brackets(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Places for brackets without their other half, in lines near a fault."""
    lines = {(each.position.file, each.position.line) for each in faults if each.severity is Severity.ERROR}
    opened: list[int] = []
    for place, token in enumerate(tokens):
        if token.word in NAMED_BY or token.word == "SPC_FCT":
            yield from _parameters(tokens, place, lines)
        if opened and _begins(tokens, place):
            yield from _closers(tokens, opened, place)
            opened.clear()
        if token.kind is not Kind.SIGN:
            continue
        if token.text in CLOSING:
            opened.append(place)
        elif token.text in PAIRS and opened and tokens[opened[-1]].text == PAIRS[token.text]:
            opened.pop()
        elif token.text in PAIRS and (token.position.file, token.position.line) in lines:
            yield from _openers(tokens, place)


def _parameters(tokens: Sequence[Token], place: int, lines: Collection[tuple[str, int]]) -> Iterator[Repair]:
    """Where the opening bracket of parameters is missing: between a name and the first type."""
    for at in range(place + 1, min(place + 6, len(tokens))):
        before, token = tokens[at - 1], tokens[at]
        listed = token.word == "VALUE" or (token.word in STARTERS and at + 1 < len(tokens) and tokens[at + 1].text == ":")
        if listed and before.kind is Kind.NAME and before.position.line == token.position.line and (token.position[:2] in lines):
            yield _sign("(", at, tokens)
            return


def _sign(sign: str, place: int, tokens: Sequence[Token]) -> Repair:
    """An opening bracket that is missing in front of the token there."""
    return Repair(place, Token.of(Kind.SIGN, sign, tokens[place - 1].end), f"'{sign}' is missing in front of {tokens[place]}")


def _begins(tokens: Sequence[Token], place: int) -> bool:
    """Whether another statement or declaration begins, which no bracket encloses."""
    token = tokens[place]
    if token.kind in (Kind.END, Kind.INSTRUCTION) or token.word in STATEMENTS:
        return True
    fresh = place > 0 and tokens[place - 1].position.line != token.position.line
    return fresh and token.kind is Kind.NAME and place + 1 < len(tokens) and tokens[place + 1].text in ("=", ":")


def _openers(tokens: Sequence[Token], place: int) -> Iterator[Repair]:
    """Where the opening bracket of this closing one may be missing: the likeliest place first."""
    gaps, depth, at = list[int](), 0, place
    while at > 0 and len(gaps) < MOST_GAPS and tokens[at - 1].position.line == tokens[place].position.line:
        at -= 1
        token = tokens[at]
        depth += (token.text in PAIRS) - (token.text in CLOSING)
        if depth < 0:
            break
        if not depth and token.text not in PAIRS:
            gaps.append(at)
    gaps.sort(key=lambda gap: (_unlikely(tokens[gap - 1], tokens[gap]), -gap))
    for gap in gaps:
        if gap:
            yield _sign(PAIRS[tokens[place].text], gap, tokens)


def _unlikely(before: Token, behind: Token) -> int:
    """How unlikely a missing opening bracket is between these."""
    if before.kind is Kind.NAME and behind.kind in OPERANDS and behind.word not in BEHIND:
        return 0 if not before.word else 1
    if before.word or before.text in ("=", ","):
        return 1 if before.text != "," else 3
    return 2


def _closers(tokens: Sequence[Token], opened: Sequence[int], end: int) -> Iterator[Repair]:
    """Yield where the closing bracket of an open one may be missing, before the construct that begins at `end`."""
    for place in reversed(opened[-MOST_OPEN:]):
        sign, depth, gaps = CLOSING[tokens[place].text], 0, list[int]()
        for at in range(place + 2, min(end, place + MOST_BEHIND) + 1):
            before = tokens[at - 1]
            depth += (before.text in CLOSING) - (before.text in PAIRS)
            if depth < 0:
                break
            if not depth and (before.kind in OPERANDS or before.text in PAIRS):
                gaps.append(at)
        gaps.sort(key=lambda gap: (_early(tokens[gap - 1], tokens[gap], sign), gap))
        for gap in gaps[:MOST_GAPS]:
            before = tokens[gap - 1]
            yield Repair(gap, Token.of(Kind.SIGN, sign, before.end), f"'{sign}' is missing after {before}")


def _early(before: Token, behind: Token, sign: str) -> int:
    """How unlikely a missing closing bracket is between these."""
    if behind.word in BEHIND or (sign == "]" and behind.text in ("=", ".", "]", ")")):
        return 0
    if behind.position.line != before.position.line or sign == "]":
        return 1
    return 2 if behind.text == "," else 3


# ---- names of declarations


def _names(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Places of declarations that lack a name, with the names that are not known elsewhere."""
    wanted = _wanted(tokens, faults)[:MOST_NAMES]
    kinematics = _named_kinematics(tokens)[:MOST_NAMES]
    for place in range(1, len(tokens)):
        before, behind = tokens[place - 1], tokens[place]
        fresh = behind.position.line != before.position.line
        if before.word in NAMED_BY and (fresh or behind.text == "("):
            own = base_name(before.position.file).partition(".")[0]
            for name in [own] if before.word == "PROGRAM" else [each.text for each in wanted]:
                yield _named(place, name, tokens)
        elif (
            behind.text == "."
            and (fresh or before.kind is not Kind.NAME or not before.touches(behind))
            and place + 1 < len(tokens)
            and tokens[place + 1].word in KINEMATIC
        ):
            for name in kinematics:
                yield _named(place, name, tokens)
        elif _lacks_name(tokens, place):
            for token in wanted:
                yield _named(place, token.text, tokens, f"{token.text} of line {token.position.line} is not declared")
            yield _named(place, "@_" if tokens[place - 2].word == "JC_POINT" else "_", tokens)


def _named_kinematics(tokens: Sequence[Token]) -> list[str]:
    """Return the names of the kinematics of the program."""
    instructions = [token.text.partition(";")[0] for token in tokens if token.kind is Kind.INSTRUCTION]
    return [name for text in instructions for name in _kinematics(text)]


def _kinematics(instruction: str) -> list[str]:
    """Return the names that an instruction assigns to kinematics."""
    return _NUMBERED.findall(instruction) if "KINEMATI" in instruction.upper() else []


def _named(place: int, name: str, tokens: Sequence[Token], hint: str = "") -> Repair:
    """A name that is missing there."""
    before, behind = tokens[place - 1 : place + 1]
    at = behind.position if behind.text == "=" else before.end
    return Repair(place, Token.of(Kind.NAME, name, at), f"a name is expected after {before}, not {behind}", hint)


def _wanted(tokens: Sequence[Token], faults: Faults) -> list[Token]:
    """Names that faults find unknown or of no use, in the order of the text."""
    lines: dict[tuple[str, int], set[str]] = {}
    for each in faults:
        if each.severity is Severity.ERROR and each.id not in ("syntax", "no-begin"):
            lines.setdefault(each.position[:2], set()).update(_NAME.findall(each.text.upper()))
    places = {each.position for each in faults if each.id == "type"}
    unknown = {each.position for each in faults if each.id == "name-unknown"}  # also a word of the other language
    found, declared, body = list[tuple[Token, set[str]]](), [set[str]()], False  # the names of the program, and of each subroutine
    for token in tokens:
        if token.word == "SUBROUTINE":
            declared.append(set())
        if token.word in (*NAMED_BY, *BEGINS):
            body = token.word in BEGINS
        if token.kind is not Kind.NAME or (token.word and token.position not in unknown):
            continue
        if not body:
            declared[-1].add(token.key)
        elif token.key in lines.get(token.position[:2], ()) or token.position in places:
            found.append((token, declared[-1]))
    return list({token.key: token for token, own in reversed(found) if token.key not in own | declared[0]}.values())[::-1]


def _lacks_name(tokens: Sequence[Token], place: int) -> bool:
    """Whether a name may be missing here, in a declaration."""
    before, behind = tokens[place - 1], tokens[place]
    if before.text not in (":", ",", "=") or not _declares(tokens, place - 1):
        return False
    if behind.text == "=":
        return before.text != "="
    if behind.kind is Kind.NAME and not behind.word:
        return behind.position.line != before.position.line and tokens[place + 1].text == "."
    listed: Collection[str] = (*STARTERS, "BEGIN", "START")
    number = behind.kind is Kind.NUMBER and before.text == "=" and tokens[place + 1].text == "="
    return behind.text in (",", ")", "(") or behind.kind in (Kind.END, Kind.INSTRUCTION) or behind.word in listed or number


# ---- signs and labels


def _signs(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Signs between two operands, in lines with a fault; and WRITE in front of a list of values."""
    lines = {each.position[:2] for each in faults if each.severity is Severity.ERROR}
    for place in range(1, len(tokens)):
        before, behind = tokens[place - 1], tokens[place]
        if before.position[:2] not in lines or before.position[:2] != behind.position[:2]:
            continue
        first = place < 2 or tokens[place - 2].position[:2] != before.position[:2]
        if first and behind.text == "," and before.kind is Kind.NAME:
            yield Repair(
                place - 1, Token.of(Kind.NAME, "WRITE", before.position, "WRITE"), f"READ or WRITE is missing in front of {before}"
            )
        if not _ends_operand(before) or not _begins_operand(behind):
            continue
        for sign in SIGNS:
            if sign == "." and behind.kind is not Kind.NAME:
                continue
            what = "an operator" if sign == "=" and not first and tokens[place - 2].text not in (",", ":") else f"'{sign}'"
            yield Repair(place, Token.of(Kind.SIGN, sign, before.end), f"{what} is missing in front of {behind}")


def _ends_operand(token: Token) -> bool:
    return (token.kind in OPERANDS and not token.word) or (token.kind is Kind.SIGN and token.text in PAIRS)


def _begins_operand(token: Token) -> bool:
    return token.kind in OPERANDS and (not token.word or token.word in KINEMATIC)


def _labels(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Colons after names that a JUMP leads to, and labels in front of a colon, each at the beginning of a line."""
    jumped = {behind.key: behind for before, behind in pairwise(tokens) if before.word == "JUMP" and behind.kind is Kind.NAME}
    if not jumped:
        return
    marked = {before.key for before, behind in pairwise(tokens) if behind.text == ":"}
    for place in range(1, len(tokens)):
        before, token = tokens[place - 1 : place + 1]
        if before.position.line == token.position.line:
            continue
        if token.text == ":":
            for name in [key for key in jumped if key not in marked][:MOST_NAMES]:
                yield Repair(
                    place, Token.of(Kind.NAME, jumped[name].text, token.position), "the name of a label is missing in front of ':'"
                )
        elif token.key in jumped and token.key not in marked and place + 1 < len(tokens):
            yield Repair(place + 1, Token.of(Kind.SIGN, ":", token.end), f"':' is missing after the label {token}")


def _declares(tokens: Sequence[Token], place: int) -> bool:
    """Return whether this colon, comma or = belongs to a declaration: a type precedes its list."""
    for at in range(place, max(place - 200, -1), -1):
        if tokens[at].word:
            return tokens[at].word in STARTERS
    return False
