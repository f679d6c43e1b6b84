"""Misspelt words of the language: which word a name was meant to be.  One slip is one fault, because the word is read as it was meant."""

from collections.abc import Collection

from gateway.pure.languages.baps2.words import Words

SHORT = 7  # letters; longer words may have two slips
LEAST = 3


def meant(text: str, words: Words, tokens: Collection[str]) -> str:
    """The spelling nearest to the text, of these tokens; "": it is a name of its own."""
    best, nearest = "", 3
    wanted = _plain(text)
    for token in tokens:
        for spelling in words.spellings.get(token, ()):
            word = _plain(spelling.text)
            far = _distance(wanted, word)
            if far <= _allowed(wanted, word) and far < nearest:
                best, nearest = spelling.text, far
    return best


def _plain(text: str) -> str:
    return text.upper().replace("_", "")


def _allowed(wanted: str, word: str) -> int:
    """How many slips two texts may differ by; a number in a name is no slip (WAIT1 is a name)."""
    if sum(map(str.isdigit, wanted)) != sum(map(str.isdigit, word)) or len(wanted) < LEAST:
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
