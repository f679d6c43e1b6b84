"""Instructions on any variable, arrays and collections.  Source: VAL 3 reference 2.5.4-2.5.6, L1055-1355; doubt D47."""

from collections.abc import Callable, Iterable

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.model import MOST_VALUES
from gateway.pure.languages.val3.values import (
    Container,
    FrameV,
    Grid,
    PointV,
    Structure,
    ToolV,
    UserV,
    copied,
    grown,
    may_hang,
    places,
    rounded,
)

Maker = Callable[[], object]


class Local(tuple[list[object], int]):
    """A local array as a parameter of an instruction: it does not grow."""

    def __new__(cls, values: list[object], start: int) -> "Local":
        """Container and first place."""
        return super().__new__(cls, (values, start))


class LocalPlace(int):
    """Where a local array begins that is passed by reference: in the program that has it, it does not grow either (71)."""


def part_of(start: object, place: int) -> int:
    """Return a place in a passed array: the part from there on is as local as the array."""
    return LocalPlace(place) if isinstance(start, LocalPlace) else place


def kept(values: list[object], place: int, start: object) -> tuple[list[object], int]:
    """An array that was passed, as a parameter of an instruction."""
    return Local(values, place) if isinstance(start, LocalPlace) else (values, place)


def is_kept(start: object) -> bool:
    """Return whether a local array begins there."""
    return isinstance(start, LocalPlace)


class _One(list[object]):
    """One value as an array of size 1 (L957): an assignment writes the original value."""

    def __init__(self, holder: object, key: object) -> None:
        self._holder, self._key = places(holder), key
        super().__init__([self._holder[key]])

    def __setitem__(self, at: object, value: object) -> None:
        if isinstance(at, int):
            if at >= len(self):
                raise IndexError(at)
            super().__setitem__(slice(at, at + 1), [value])
        elif isinstance(at, slice) and isinstance(value, Iterable):
            super().__setitem__(slice(at.start, at.stop), value)
        self._holder[self._key] = self[0]


def one(holder: object, key: object) -> Local:
    """Return a field, an entry or a parameter by reference where an instruction requires an array."""
    return Local(_One(holder, key), 0)


def ix(index: float) -> int:
    """Return an index rounded to the nearest integer; 21 below 0.  Above the size the list itself raises."""
    return rounded(index)


def key(collection: dict[str, object], name: str) -> str:
    """A key that is there; 23 for an empty one, 25."""
    if name in collection:
        return name
    raise Rte(25 if name else 23, f"key {name!r}")


def there(container: Container, place: object) -> object:
    """A place that is passed by reference: the line that passes it stops with 20, not the one that uses it."""
    if isinstance(container, list) and isinstance(place, int) and place >= len(container):
        raise Rte(20, f"index {place} of {len(container)}")
    return place


def store(container: dict[object, object], place: object, value: object) -> object:
    """= of plain values, as an expression."""
    container[place] = value
    return value


def take(target: Structure, value: object) -> object:
    """= of structures, as an expression."""
    if target is not value:
        target.set(value.copy() if isinstance(value, UserV) else value)  # a user value may be a part of the target
    return target


def take_linked(target: FrameV | ToolV | PointV, value: FrameV | ToolV | PointV) -> object:
    """= of frames, tools and points: the reference is taken, too; 165."""
    may_hang(target, value.father)
    return take(target, value)


def f_size(container: Container, offset: object) -> float:
    """Elements, from `offset` on."""
    if isinstance(container, list) and isinstance(offset, int):
        return float(max(len(container) - offset, 0))
    return float(len(container)) if not isinstance(container, Grid) else float(container.dims[0])


def f_size_of(container: Container, offset: object, dimension: float) -> float:
    """Of a dimension, counted from 1; 0 where there is none."""
    which = rounded(dimension)
    if isinstance(container, Grid):
        return float(container.dims[which - 1]) if 1 <= which <= len(container.dims) else 0.0
    return f_size(container, offset) if which == 1 else 0.0


def f_is_defined(find: Callable[[], Container], offset: int, place: tuple[object, ...] | None) -> bool:
    """Whether the element, the key or the datum of a library is there."""
    try:
        container = find()
    except (Rte, LookupError):  # its container does not exist
        return False
    if place is None:
        return True
    if isinstance(container, dict):
        return place[0] in container
    try:
        numbers = [rounded(float(each)) for each in place if isinstance(each, float | int)]
    except Rte:
        return False
    sizes = container.dims if isinstance(container, Grid) else (len(container) - offset,)
    return all(number < size for number, size in zip(numbers, sizes, strict=True))


def _growing(container: Container, local: bool, more: int = 1) -> None:
    if local:
        raise Rte(71)
    if not isinstance(container, Grid) and len(container) + more > MOST_VALUES:
        raise Rte(40, f"more than {MOST_VALUES} values")


def f_insert(container: Container, place: object, make: Maker, local: bool) -> bool:
    """A new value at an index or under a key; false: the key is there."""
    if isinstance(container, dict):
        name = str(place)
        if not name:
            raise Rte(23)
        if name in container:
            return False
        _growing(container, local)
        container[name] = grown(container, make)()
        return True
    _growing(container, local)
    if not isinstance(container, list) or not isinstance(place, int) or place > len(container):
        raise Rte(20, f"index {place}")
    container.insert(place, grown(container, make)())
    return True


def f_delete(container: Container, place: object, make: Maker, local: bool) -> bool:
    """Removes a value; the last one of an array stays: 70 (D47)."""
    if isinstance(container, dict):
        del container[key(container, str(place))]
        return True
    if local:
        raise Rte(71)
    if not isinstance(container, list) or not isinstance(place, int) or place >= len(container):
        raise Rte(20, f"index {place}")
    if len(container) == 1:
        raise Rte(70, "an array keeps one element")
    del container[place]
    return True


def f_append(container: list[object], make: Maker, local: bool) -> None:
    """A new value at the end."""
    _growing(container, local)
    container.append(grown(container, make)())


def f_resize(container: Container, dimension: float, size: float, make: Maker, local: bool) -> None:
    """Adds or drops values at the end of a dimension."""
    if local or (isinstance(container, Grid) and container.local):
        raise Rte(71)
    which, wanted = rounded(dimension), rounded(size)
    dims, make = container.dims if isinstance(container, Grid) else (len(container),), grown(container, make)
    if not 1 <= which <= len(dims) or wanted < 1:
        raise Rte(70, f"resize of dimension {which} to {wanted}")
    if isinstance(container, Grid):
        container.resize(which - 1, wanted, make)
    elif isinstance(container, list):
        if wanted > MOST_VALUES:
            raise Rte(40, f"{wanted} values, {MOST_VALUES} at most")
        del container[wanted:]
        container.extend(make() for _ in range(wanted - len(container)))


def f_first(container: dict[str, object]) -> str:
    """The first key in alphabetical order."""
    return min(container, default="")


def f_last(container: dict[str, object]) -> str:
    """The last key."""
    return max(container, default="")


def f_next(container: dict[str, object], name: str) -> str:
    """Return the key after this one; "" after the last."""
    here = key(container, name)
    return min((each for each in container if each > here), default="")


def f_prev(container: dict[str, object], name: str) -> str:
    """Return the key before this one."""
    here = key(container, name)
    return max((each for each in container if each < here), default="")


def copy_values(source: list[object], start: int, target: list[object], first: int) -> int:
    """Copy until one of the two ends; return the number.  Both may be parts of one array: the previous values are copied."""
    amount = min(len(source) - start, len(target) - first)
    for at, value in enumerate([copied(each) for each in source[start : start + amount]]):
        mine = target[first + at]
        if isinstance(mine, Structure):
            mine.set(value)
        else:
            target[first + at] = value
    return amount
