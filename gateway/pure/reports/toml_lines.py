"""Line of a key in a TOML file.

tomllib returns values without places, so messages could only name a key. This walks the text once and knows just enough
TOML for it: headers, keys, strings, comments and the nesting of arrays and inline tables. It never judges the file.
"""

import re

Path = tuple[str | int, ...]
_KEY = re.compile(r"""\s*((?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*'))*)\s*=""")
_HEADER = re.compile(r"\s*(\[\[?)\s*([^\]]+?)\s*\]")
_STRING = re.compile(r"'''.*?'''|\"\"\".*?\"\"\"|'[^'\n]*'|\"(?:\\.|[^\"\\\n])*\"", re.S)


def lines_of(text: str) -> dict[Path, int]:
    """Path of every table, key and array element -> its line, counted from 1."""
    places: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    prefix: Path = ()
    position, line = 0, 1
    while position < len(text):
        end = position
        if found := _HEADER.match(text, position):
            prefix = _open(found[1] == "[[", _split(found[2]), counts)
            for end in range(1, len(prefix) + 1):
                places.setdefault(prefix[:end], _line(text, found.start(2)))
            end = found.end()
        elif found := _KEY.match(text, position):
            end = _value(text, found.end(), (*prefix, *_split(found[1])), places, _line(text, found.start(1)))
        newline = text.find("\n", end)
        position = len(text) if newline < 0 else newline + 1
        line += 1
    return places


def nearest(places: dict[Path, int], path: Path) -> int | None:
    """The line of a path, or of the closest table around it."""
    while path:
        if path in places:
            return places[path]
        path = path[:-1]
    return None


def _line(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def _split(dotted: str) -> tuple[str, ...]:
    parts = re.findall(r"[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'", dotted)
    return tuple(part.strip("\"'") for part in parts)


def _open(array: bool, names: tuple[str, ...], counts: dict[Path, int]) -> Path:
    """The path of a header: every name that is an array of tables gets the number of its last element."""
    path: Path = ()
    for number, name in enumerate(names):
        path = (*path, name)
        if array and number == len(names) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def _value(text: str, position: int, path: Path, places: dict[Path, int], line: int) -> int:
    """Note a value and its nested values; return the position after it."""
    places[path] = line
    stack: list[Path] = []  # open arrays (path with the running number) and inline tables (path as it is)
    array: list[bool] = []
    here = path
    while position < len(text):
        char = text[position]
        if found := _STRING.match(text, position):
            if stack and array[-1]:
                places.setdefault(stack[-1], _line(text, position))
            position = found.end()
            continue
        if char == "#":
            newline = text.find("\n", position)
            position = len(text) if newline < 0 else newline
            continue
        if char in "[{":
            stack.append((*here, 0) if char == "[" else here)
            array.append(char == "[")
            here = stack[-1]
            if char == "{":
                places[here] = _line(text, position)
        elif char in "]}" and stack:
            stack.pop()
            array.pop()
            here = stack[-1] if stack else path
        elif char == "," and stack and array[-1]:
            stack[-1] = _next(stack[-1])
            here = stack[-1]
        elif char == "\n" and not stack:
            return position
        elif stack and (found := _KEY.match(text, position)) and not array[-1]:
            here = (*stack[-1], *_split(found[1]))
            places[here] = _line(text, found.start(1))
            position = found.end()
            continue
        elif stack and array[-1] and not char.isspace():
            places.setdefault(stack[-1], _line(text, position))
        position += 1
    return position


def _next(path: Path) -> Path:
    last = path[-1]
    return (*path[:-1], last + 1 if isinstance(last, int) else 0)
