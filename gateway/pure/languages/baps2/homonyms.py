"""Words of the language that are names in a text: an English program of a German plant has a label ENDE, a variable BAND (AX-1747)."""

from collections.abc import Collection, Iterable, Iterator
from itertools import pairwise

from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.words import Words

ASSIGNED = ("=", ".", "[")  # after a name that is assigned to
CALLING = ("JUMP", "SUBROUTINE")
IN_FRONT = "TO VIA AND OR NOT IF UNTIL WAIT WRITE READ JUMP CASE REPEAT".split()  # of a name
ENGLISH = "en"
ENDS = ("PROGRAM_END", "SUB_END", "END")
DECLARES = "INTEGER REAL BINARY CHAR TEXT POINT JC_POINT WC_FRAME ARRAY INPUT OUTPUT FILE BNR_FILE SEMAPHORE CONST EXTERNAL SPC_FCT"
BEGINS = frozenset(("BEGIN", "START", *DECLARES.split()))  # after the name of a routine without parameters


def language_of(tokens: Iterable[Token], words: Words) -> str:
    """The language of a text: that of its word PROGRAM or SUBROUTINE."""
    first = next((token for token in tokens if token.word in ("PROGRAM", "SUBROUTINE")), None)
    return words.language(first.text) if first is not None else ENGLISH


def is_foreign(token: Token, language: str, words: Words) -> bool:
    """Whether a word is one of the other language alone: no compiler of this language knows it (L11298-11322)."""
    if not token.word or words.language(token.text) == language:
        return False
    return any(each.language == language for each in words.spellings[token.word])


def no_subroutines(tokens: list[Token], words: Words) -> Iterator[int]:
    """Yield the places where the word UP does not begin a subroutine but is a name (an output UP next to one DOWN)."""
    places = [place for place, token in enumerate(tokens) if token.word == "SUBROUTINE"]
    language = language_of(tokens, words) if places else ""
    for place in places:
        if is_foreign(tokens[place], language, words):
            begins = _begins_routine(tokens, place)
        else:
            begins = not _is_operand(tokens, place)
        if not begins:
            yield place


def _is_operand(tokens: list[Token], place: int) -> bool:
    """Return whether a word of the own language that begins a subroutine is a name: its neighbours allow nothing else."""
    before, behind = tokens[max(place - 1, 0)], tokens[min(place + 1, len(tokens) - 1)]
    if behind.kind is Kind.SIGN and behind.text != "(":
        return True
    if not place or before.word in ENDS:
        return False
    operand = (before.kind is Kind.SIGN and before.text not in (")", "]")) or before.word in IN_FRONT
    return operand or bool(behind.word and behind.word not in BEGINS)


def _begins_routine(tokens: list[Token], place: int) -> bool:
    """Return whether a name and the beginning of a routine follow the end of another one."""
    name, behind = tokens[min(place + 1, len(tokens) - 1)], tokens[min(place + 2, len(tokens) - 1)]
    begins = behind.text == "(" or behind.word in BEGINS or behind.kind is Kind.INSTRUCTION
    before = tokens[place - 1] if place else None
    ended = before is None or before.word in ENDS or before.kind is Kind.INSTRUCTION
    return ended and name.kind is Kind.NAME and not name.word and begins


def called(tokens: Iterable[Token]) -> tuple[set[str], set[str]]:
    """Names of the subroutines of a text, and names that a JUMP leads to."""
    routines, jumped = set[str](), set[str]()
    for before, behind in pairwise(tokens):
        if before.word in CALLING and behind.kind is Kind.NAME:
            (jumped if before.word == "JUMP" else routines).add(behind.key)
    return routines, jumped


def labels_among(names: Collection[str], tokens: Iterable[Token]) -> set[str]:
    """Those of the names that a colon follows somewhere."""
    return {before.key for before, behind in pairwise(tokens) if behind.text == ":" and before.key in names} if names else set()


def named(tokens: list[Token], first: int, names: Collection[str], labels: Collection[str], words: Words) -> Iterator[int]:
    """Places in the routine from `first` on where a word is a name: declared and assigned to, or of the other language, or a label."""
    language = language_of(tokens, words)
    for place in range(first, len(tokens) - 1):
        token = tokens[place]
        if token.word == "SUBROUTINE":  # its own names are looked at when it is read
            return
        if not token.word:
            continue
        behind = tokens[place + 1].text if tokens[place + 1].kind is Kind.SIGN else ""
        label = token.key in labels and (behind == ":" or tokens[place - 1].word == "JUMP")
        if label or (token.key in names and (behind in ASSIGNED or is_foreign(token, language, words))):
            yield place
