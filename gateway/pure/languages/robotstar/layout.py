"""The lines of a printed page as steps: two columns in sequence, broken lines joined, misread step numbers corrected."""

import re
from collections.abc import Callable, Iterable, Sequence

Line = tuple[int, str]  # number in the file, text
Note = Callable[[int, str], None]
_TWO = re.compile(r"^(\s*S?\d+[.:)]?\s+\S.*?)(?:\s+[|¦]\s*|\s{3,})(S?\d+[.:)]?\s+\\?[^\W\d].*)$")
_HEADED = re.compile(r"S?1[.:)]?\s+(?:MPR?|SPR?|MAC|PAL|PLC)\s", re.IGNORECASE)
_LEFT = re.compile(r"^(\s*S?\d+[.:)]?\s+.*?|\s+\S.*?)\s+[|¦]\s*$")
_NUMBERED = re.compile(r"^\s*\W{0,2}\s*S?\d+\s*[.:)]?(\s|$)", re.IGNORECASE)
_MISREAD = re.compile(r"^(\s*S?)(?=[\dOolI]*\d)([\dOolI]{1,4})(\s+[^\W\d])")
_OPEN_NAME = re.compile(r"(?<!#)<\s*\w[^<>]*$")  # POSITION <over the gripping
_COMMENT = re.compile(r"^\s*S?\d+\s*[.:)]?\s+C\s", re.IGNORECASE)
_DESCRIPTOR = re.compile(r"^\s*([A-Za-z]\w*(?:[- ]\w+)?)\s*:\s*\S")


def steps_of(text: str, is_descriptor: Callable[[str], bool], is_command: Callable[[str], bool], note: Note) -> list[Line]:
    """All lines in the order they are read."""
    found: list[Line] = []
    for number, line in _one_column(enumerate(text.splitlines(), 1), note):
        fixed = _MISREAD.sub(lambda match: match[1] + match[2].translate(_DIGITS) + match[3], line)
        if fixed != line:
            note(number, f"{line.split()[0]} is read as {fixed.split()[0]}")
        if found and _continues(found[-1][1], fixed, is_descriptor, is_command):
            before, (first, line) = line, found.pop()
            broken = line.rstrip().endswith("-") and not _NUMBERED.match(before)
            joined = line.rstrip()[:-1] + before.strip() if broken and _COMMENT.match(line) else f"{line.rstrip()} {before.strip()}"
            found.append((first, joined))
            note(number, f"{before.strip()} belongs to the line before")
        else:
            found.append((number, fixed))
    return found


def is_numbered(lines: Iterable[str]) -> bool:
    """Whether steps are printed with their numbers: a line without one is then a title, or a command whose number is lost."""
    filled = [line for line in lines if line.strip()]
    return 3 * sum(bool(_NUMBERED.match(line)) for line in filled) > 2 * len(filled)


def with_lost_numbers(lines: Sequence[Line], note: Note) -> list[Line]:
    """A single line without a number, or with another one, between step n and step n + 2 is the step between them."""
    found = list(lines)
    printed = [_printed(line) for _, line in lines]
    filled = [at for at, (_, line) in enumerate(lines) if line.strip()]
    for before, at, behind in zip(filled, filled[1:], filled[2:], strict=False):
        number, line = lines[at]
        lost = printed[before] + 1
        if not printed[behind] - 1 == lost > 1 or printed[at] == lost:
            continue
        step = _NUMBERED.sub("", line, count=1) if printed[at] else line
        if re.match(r"\s*\\?[^\W\d]", step):
            found[at] = number, f"{lost} {step.strip()}"
            note(number, f"{line.strip()} is read as {found[at][1]}")
    return found


def _printed(line: str) -> int:
    """The number of a step; 0: none is printed."""
    found = _NUMBERED.match(line)
    return int(re.sub(r"\D", "", found[0])) if found else 0


_DIGITS = str.maketrans("OolI", "0011")


def _one_column(lines: Iterable[Line], note: Note) -> list[Line]:
    """A page in two columns: the right one follows the left one."""
    found: list[Line] = []
    right: list[Line] = []
    for number, line in lines:
        two = _TWO.match(line) if line.count("|") < 2 else None
        if two and _follows(two, right):
            if not right:
                note(number, "two columns are read one after the other")
            found.append((number, two[1]))
            right.append((number, two[2]))
        elif right and (left := _LEFT.match(line)):
            found.append((number, left[1]))
        else:
            if right and not line.strip():
                found += right
                right = []
            found.append((number, line))
    return found + right


def _follows(two: "re.Match[str]", right: list[Line]) -> bool:
    """Return whether the right column is numbered on: after the left one, or from the head of another program on."""
    left, own = (int(re.sub(r"\D.*", "", part.strip().lstrip("Ss"))) for part in (two[1], two[2]))
    last = int(re.sub(r"\D.*", "", right[-1][1].strip().lstrip("Ss"))) if right else 0
    headed = _HEADED.match(right[0][1] if right else two[2])
    return own > last and (own > left or headed is not None)


def _continues(before: str, line: str, is_descriptor: Callable[[str], bool], is_command: Callable[[str], bool]) -> bool:
    """Return whether a line without a number continues an incomplete step with one."""
    if not _NUMBERED.match(before) or _NUMBERED.match(line) or not line.strip() or line.lstrip().startswith(("|", "`", "*", "#")):
        return False
    words = line.split()
    if _OPEN_NAME.search(before):
        return ">" in line
    if before.rstrip().endswith(","):
        return not is_command(words[0])
    if _COMMENT.match(before):
        return before.rstrip().endswith("-")
    given = _DESCRIPTOR.match(line)
    return given is not None and is_descriptor(given[1]) and not is_command(given[1])
