"""A block that lacks its end, or its BEGIN: the way the lines are indented shows where (AX-1835)."""

from collections.abc import Iterator, Sequence

from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.repair import Repair
from gateway.pure.languages.base.faults import Faults, Severity

ENDS = {"BEGIN": "END", "REPEAT": "REPEAT_END", "CASE": "CASE_END", "PARALLEL": "PARALLEL_END", "EXCLUSIVE": "EXCLUSIVE_END"}
ROUTINES = ("PROGRAM", "SUBROUTINE")
CONTINUE = {"PARALLEL": ("ALSO",), "CASE": ("EQUAL", "DEFAULT", "ELSE")}  # a block, in a line that is not indented
LINES = ("THEN", "ELSE", "ERROR", "DEFAULT")  # may be the last word of a line, in front of BEGIN


def blocks(tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
    """Ends and BEGINs that are missing."""
    errors = [each for each in faults if each.severity is Severity.ERROR]
    if any(each.id == "not-closed" for each in errors):
        yield from _ends(tokens)
    if any("'END' without" in each.text or "'ENDE' without" in each.text for each in errors):
        yield from _begins(tokens, max(each.position.line for each in errors))


def _ends(tokens: Sequence[Token]) -> Iterator[Repair]:
    """Ends in front of the first line that is not indented more than the one with the beginning, where there is none."""
    indents = _indents(tokens)
    declares = True
    for place, token in enumerate(tokens):
        declares = token.word in ROUTINES or (declares and token.word != "BEGIN")
        end = ENDS.get(token.word, "")
        if not end or declares or (token.word == "BEGIN" and _of_routine(tokens, place)):
            continue
        behind = _not_indented(tokens, indents, place)
        if behind and tokens[behind].word != end:
            closing = Token.of(Kind.NAME, end, tokens[behind - 1].end, end)
            yield Repair(
                behind,
                closing,
                f"{token.word} has no {end}",
                f"it is missing in front of line {tokens[behind].position.line}",
                at=token.position,
                id="not-closed",
            )


def _of_routine(tokens: Sequence[Token], place: int) -> bool:
    """Whether this BEGIN is the one of a program or subroutine: no other one precedes it."""
    for at in range(place - 1, -1, -1):
        if tokens[at].word in ("BEGIN", "START"):
            return False
        if tokens[at].word in ROUTINES:
            return True
    return True


def _indents(tokens: Sequence[Token]) -> dict[tuple[str, int], int]:
    """The column of the first token of each line."""
    found: dict[tuple[str, int], int] = {}
    for token in tokens:
        found.setdefault(token.position[:2], token.position.column)
    return found


def _not_indented(tokens: Sequence[Token], indents: dict[tuple[str, int], int], place: int) -> int:
    """The first token of the line that ends the block by its column; 0: the block is not indented."""
    own, line, body = indents[tokens[place].position[:2]], tokens[place].position[:2], False
    for at in range(place + 1, len(tokens)):
        token = tokens[at]
        if token.position[:2] == line or token.kind is Kind.INSTRUCTION:
            continue
        line = token.position[:2]
        if token.position.column > own:
            body = True
        elif token.word not in CONTINUE.get(tokens[place].word, ()):
            return at if body else 0
    return 0


def _begins(tokens: Sequence[Token], last: int) -> Iterator[Repair]:
    """BEGIN behind what ends its line and lacks a statement there: the nearest to the fault first."""
    equal = 0  # line of the last EQUAL
    found: list[Repair] = []
    for place in range(1, len(tokens)):
        before, token = tokens[place - 1 : place + 1]
        equal = before.position.line if before.word == "EQUAL" else equal
        colon = before.text == ":" and before.position.line == equal
        fresh = token.position.line != before.position.line
        if fresh and (colon or before.word in LINES) and token.word != "BEGIN" and token.position.line <= last:
            begin = Token.of(Kind.NAME, "BEGIN", before.end, "BEGIN")
            found.append(Repair(place, begin, f"BEGIN is missing after {before}", "put several statements between BEGIN and END"))
    yield from reversed(found)
