"""Which word a misspelt one was meant to be: letters that are missing, too many, wrong or have changed places."""

from collections.abc import Iterable, Mapping, Sequence

SHORT = 7  # letters; longer words may have two slips
LEAST = 3
_LOOKS = str.maketrans("OQIL|SBZ", "00111582")
MOST_HINTS = 100  # faults of one kind after which a reader stops searching for similar words: a foreign file


def nearest(text: str, words: Iterable[str]) -> str:
    """The word most like the text, the first of several; "": none is like it.  Case and underscores do not count."""
    return next(iter(all_nearest(text, words)), "")


def all_nearest(text: str, words: Iterable[str]) -> list[str]:
    """The words most like the text in their order: more than one where the text is equally near to them."""
    best: list[str] = []
    least = 3
    wanted = _plain(text)
    letters = set(wanted)
    for word in words:
        plain = _plain(word)
        difference = abs(len(wanted) - len(plain))
        if difference > least:
            continue
        slips = min(_allowed(wanted, plain), least)
        if difference > slips or len(letters - set(plain)) > slips:
            continue  # most words, without counting
        far = _distance(wanted, plain)
        if far > slips:
            continue
        best = [*best, word] if far == least else [word]
        least = far
    return best


def meant(text: str, table: Mapping[str, str]) -> list[str]:
    """The spellings of a table that look like the text or are most like it, the first of each meaning."""
    alike = [spelling for spelling in table if looks(spelling) == looks(text)] or all_nearest(text, table)
    found = {table[spelling]: spelling for spelling in reversed(alike)}
    return [*reversed(found.values())]


def hint_of(name: str, names: Iterable[str]) -> str:
    """The remedy for a name that is not known; "": none is like it."""
    return hint_with(all_nearest(name, sorted(each for each in names if each != name)))


def hint_for_print(text: str, words: Sequence[str]) -> str:
    """The remedy for a name that may be misread from a print (M1 for ML), however short it is; "": none is like it."""
    return hint_with([word for word in words if looks(word) == looks(text)] or all_nearest(text, words))


def looks(text: str) -> str:
    """What print may be taken for: the same for texts that look alike."""
    return text.upper().translate(_LOOKS)


def hint_with(words: Sequence[str]) -> str:
    """The remedy with the words a text may have been meant to be; "": with none."""
    if len(words) < 2:
        return f"did you mean {words[0]}?" if words else ""
    return f"did you mean {words[0]} or {words[1]}?"


def _plain(text: str) -> str:
    return text.upper().replace("_", "")


def _allowed(wanted: str, word: str) -> int:
    """How many slips two texts may differ by; another number in a name is not a slip (WAIT1 is a name, PB20 not PB21)."""
    if [*filter(str.isdigit, wanted)] != [*filter(str.isdigit, word)] or len(wanted) < LEAST:
        return -1
    if max(len(wanted), len(word)) == LEAST:  # only letters that changed places
        return 1 if sorted(wanted) == sorted(word) else 0
    return 2 if min(len(wanted), len(word)) >= SHORT else 1


def _distance(one: str, other: str) -> int:
    """Letters that are too many, missing, wrong or have changed places; more than 2 is not counted exactly."""
    if abs(len(one) - len(other)) > 2:
        return 3
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, letter in enumerate(one, 1):
        above, last = row, before
        row = [i]
        for j, against in enumerate(other, 1):
            cost = min(above[j] + 1, row[j - 1] + 1, above[j - 1] + (letter != against))
            if i > 1 and j > 1 and letter == other[j - 2] and one[i - 2] == against:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
        before = above
    return row[-1]
