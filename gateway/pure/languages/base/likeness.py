"""Which name a misspelt one was meant to be: letters that are too many, missing, wrong or have changed places."""

from collections.abc import Iterable

SHORT = 7  # letters; longer names may have two slips
LEAST = 3
FAR = 3  # more than two slips are not counted exactly
UMLAUTS = str.maketrans({"Ä": "AE", "Ö": "OE", "Ü": "UE", "ẞ": "SS"})


def plain(text: str) -> str:
    """As texts are compared: without case, underscores and umlauts."""
    return text.upper().translate(UMLAUTS).replace("_", "")


def like(name: str, names: Iterable[str]) -> str:
    """The one of the names that this one was meant to be; "": none is like it."""
    wanted = plain(name)
    found = [(distance(wanted, plain(each)), each) for each in names if each != name]
    near = [(far, each) for far, each in found if far <= allowed(wanted, plain(each))]
    return min(near)[1] if near else ""


def hint_of(name: str, names: Iterable[str]) -> str:
    """The remedy for a name that is not known; "": none is like it."""
    found = like(name, names)
    return f"{found} is the name like it" if found else ""


def allowed(wanted: str, word: str) -> int:
    """How many slips two texts may differ by; a number in a name is no slip (WAIT1 is a name)."""
    if sum(map(str.isdigit, wanted)) != sum(map(str.isdigit, word)) or len(wanted) < LEAST:
        return -1
    if max(len(wanted), len(word)) == LEAST:  # only letters that changed places
        return 1 if sorted(wanted) == sorted(word) else 0
    return 2 if min(len(wanted), len(word)) >= SHORT else 1


def distance(one: str, other: str) -> int:
    """How many slips are between two texts."""
    if abs(len(one) - len(other)) >= FAR:
        return FAR
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
