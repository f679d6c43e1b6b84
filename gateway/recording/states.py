"""The state a recording begins with: the objects of the cycle's core and buses at rest, as JSON that runs no code (AX-484).

The cycle pickles its objects, in less than a millisecond; the recorder makes `frozen` trees of them.  A replay builds the same
objects out of the cell, freezes them as well and carries over only what differed: what a cell file sets comes from the cell replayed.
"""

import enum
import importlib
import io
import pickle
from collections import deque
from collections.abc import Callable
from typing import Any

from gateway.recording.kinds import id_of, location_of

OURS = ("gateway.pure.", "drivers.drives.", "motion.", "protocols.")
PLAIN = (bool, int, float, str)
CONTAINERS = (bytearray, deque)


class StateError(Exception):
    """A state that cannot be carried over; the message names the part."""


class Kept:
    """Replaces what is not carried: settings of the cell by their number, solvers that hold nothing at rest (-1)."""

    def __init__(self, number: int = -1) -> None:
        self.number = number


class Numbers:
    """Replaces an array: its numbers are state as any other."""

    def __init__(self, shape: list[int], kind: str, octets: bytes) -> None:
        self.shape, self.kind, self.octets = shape, kind, octets


class Start:
    """All that the script of the cycles continues."""

    def __init__(
        self, core: object, families: list[Any], late: list[int], sent_ns: list[int], encoders: "list[list[int | None]] | None" = None
    ) -> None:
        """`encoders`: for each belt its bus, its identifier, its last telegram (None: nothing yet), its count."""
        self.core, self.families, self.late, self.sent_ns = core, families, late, sent_ns
        self.encoders = encoders or []


class Snapshots:
    """Snapshots of one cycle process; created before its first cycle, so that its values at that time count as settings."""

    def __init__(self, *roots: object) -> None:
        self.settings: list[object] = []  # in the order they are met, which is the same for the same cell
        self._known: dict[int, int] = {}
        self._dump(roots, self._learn)

    def take(self, start: Start) -> bytes:
        """Pickled."""
        return self._dump(start, self._leave_out)

    def _dump(self, root: object, look: Callable[[object], "Kept | None"]) -> bytes:
        file = io.BytesIO()
        try:
            _Pickler(file, look).dump(root)
        except (TypeError, AttributeError, RecursionError, pickle.PicklingError) as error:
            raise StateError(f"a state that cannot be handed over: {error}") from error
        return file.getvalue()

    def _learn(self, value: object) -> Kept | None:
        if _is_frozen(type(value)) and id(value) not in self._known:
            self._known[id(value)] = len(self.settings)
            self.settings.append(value)  # kept alive, or its id might be reused
        return Kept() if _solver(value) else None

    def _leave_out(self, value: object) -> Kept | None:
        number = self._known.get(id(value))
        if number is not None:
            return Kept(number)
        return Kept() if _solver(value) else None


class _Pickler(pickle.Pickler):
    def __init__(self, file: io.BytesIO, look: Callable[[object], "Kept | None"]) -> None:
        super().__init__(file, 5)
        self._look = look

    def reducer_override(self, value: Any) -> Any:
        if _array(value):
            return Numbers, (list(value.shape), value.dtype.str, value.tobytes())
        if isinstance(value, enum.Enum):  # Python before 3.11.4 reduces it by getattr, a function, and functions are left out
            return type(value), (value.value,)
        kept = self._look(value) if type(value) is not Kept else None
        return (Kept, (kept.number,)) if kept is not None else NotImplemented


def _array(value: object) -> bool:
    """A numpy array, without loading numpy."""
    return type(value).__name__ == "ndarray" and type(value).__module__ == "numpy"


def _solver(value: object) -> bool:
    """Whether a value is a solver, function or codec: not a class, not an object of this package, not a plain container.  A part in C of
    one of our classes declares itself what it is stored as.
    """
    kind = type(value)
    ours = any(f"{each.__module__}.".startswith((*OURS, f"{__name__}.")) for each in kind.__mro__)
    return not (isinstance(value, type) or kind in CONTAINERS or ours)


def _is_frozen(kind: type) -> bool:
    settings = getattr(kind, "__dataclass_params__", None)
    return settings is not None and bool(settings.frozen)


# ---- trees


def frozen(root: object) -> Any:
    """JSON of an object and all it holds."""
    return _Freezer().freeze(root)


class _Freezer:
    def __init__(self) -> None:
        self._seen: dict[int, int] = {}
        self._held: list[object] = []  # so that no number of an object is reused

    def freeze(self, value: object) -> Any:
        if value is None or type(value) in PLAIN:
            return value
        if isinstance(value, enum.Enum):
            return {"enum": id_of(type(value)), "value": self.freeze(value.value)}
        if isinstance(value, bytes):
            return {"bytes": value.hex()}
        if isinstance(value, tuple):
            kind = {} if type(value) is tuple else {"class": id_of(type(value))}
            return {"tuple": [self.freeze(each) for each in value], **kind}
        if isinstance(value, set | frozenset):
            return {type(value).__name__: sorted((self.freeze(each) for each in value), key=repr)}
        if isinstance(value, Kept):
            return {"kept": "setting" if value.number >= 0 else "solver", "setting": value.number}
        return self._changing(value)

    def _changing(self, value: Any) -> Any:
        """Objects that two places may share."""
        if id(value) in self._seen:
            return {"same": self._seen[id(value)]}
        self._seen[id(value)] = number = len(self._seen)
        self._held.append(value)
        if isinstance(value, bytearray):
            return {"bytearray": value.hex(), "number": number}
        if isinstance(value, deque):
            return {"deque": [self.freeze(each) for each in value], "most": value.maxlen, "number": number}
        if isinstance(value, list):
            return {"list": [self.freeze(each) for each in value], "number": number}
        if _array(value):
            value = Numbers(list(value.shape), value.dtype.str, value.tobytes())
            self._held.append(value)
        if isinstance(value, Numbers):
            return {"array": value.octets.hex(), "shape": value.shape, "kind": value.kind, "number": number}
        if isinstance(value, dict):
            return {"dict": [[self.freeze(key), self.freeze(each)] for key, each in value.items()], "number": number}
        if type(value).__module__.startswith(OURS):
            return {"object": id_of(type(value)), "has": {k: self.freeze(v) for k, v in _attributes(value).items()}, "number": number}
        return {"kept": type(value).__name__}


def _attributes(value: object) -> dict[str, object]:
    slots = [name for kind in type(value).__mro__ for name in _slots(kind)]
    found = {name: getattr(value, name) for name in slots if hasattr(value, name)}
    return found | dict(getattr(value, "__dict__", {}))


def _slots(kind: type) -> tuple[str, ...]:
    slots = kind.__dict__.get("__slots__", ())
    return tuple(name for name in ((slots,) if isinstance(slots, str) else slots) if name not in ("__weakref__", "__dict__"))


def places_of(recorded: list[object], target: list[object]) -> list[object]:
    """Settings of the target by their numbers in the recording; None: a changed cell has no such one.

    Used only if a setting has moved since the beginning; an unchanged one is the target's own.
    """
    if [type(each) for each in recorded] == [type(each) for each in target]:
        return target
    return [next((other for other in target if type(other) is type(each) and repr(other) == repr(each)), None) for each in recorded]


def carry_over(recorded: Any, pristine: Any, target: Any, settings: list[object]) -> Any:
    """`target` as it was in the recording where that differs from `pristine`, its cell's beginning; raises StateError.

    Changed in place where that can be done; the result is to be used in its place.  `settings`: of the target, by the recording's numbers.
    """
    return _Carrier(settings).carry(recorded, pristine, target)


class _Carrier:
    def __init__(self, settings: list[object]) -> None:
        self._made: dict[int, object] = {}
        self._settings = settings

    def carry(self, tree: Any, pristine: Any, target: Any) -> Any:
        if isinstance(tree, dict) and "number" in tree:
            self._made[tree["number"]] = target
        if tree == pristine and repr(tree) == repr(pristine):  # 1 == 1.0 == True, but they are not the same
            self._note(tree, target)
            return target
        if not isinstance(tree, dict):
            return tree
        if "kept" in tree:
            return self._kept(tree, target)
        absent = target is None and "object" in tree and isinstance(pristine, dict) and tree["object"] == pristine.get("object")
        if absent or ("same" in tree and tree["same"] not in self._made):
            return target  # absent: a part of the recorded cell that this one does not have
        if tree.get("object") and isinstance(pristine, dict) and tree["object"] == pristine.get("object") == id_of(type(target)):
            return self._object(tree, pristine, target)
        if "list" in tree and isinstance(target, list) and isinstance(pristine, dict) and len(tree["list"]) == len(target):
            target[:] = [self.carry(each, was, now) for each, was, now in zip(tree["list"], pristine.get("list", ()), target, strict=True)]
            return target
        if "bytearray" in tree and isinstance(target, bytearray):
            target[:] = bytes.fromhex(tree["bytearray"])
            return target
        if "tuple" in tree and isinstance(pristine, dict) and len(tree["tuple"]) == len(pristine.get("tuple", ())) == _length(target):
            parts = [self.carry(each, was, now) for each, was, now in zip(tree["tuple"], pristine["tuple"], target, strict=True)]
            return _of_tuple(tree, parts)
        if "dict" in tree and isinstance(target, dict):
            return self._dict(tree, pristine, target)
        return self.build(tree)

    def _kept(self, tree: Any, target: Any) -> Any:
        """A setting may be in another place than at the beginning; solvers stay."""
        number = tree.get("setting", -1)
        if not 0 <= number < len(self._settings):
            return target
        if self._settings[number] is None:
            raise StateError(f"setting {number} of the recorded cell, which this cell does not have")
        return self._settings[number]

    def _object(self, tree: Any, pristine: Any, target: Any) -> Any:
        changed = {name: self.carry(each, pristine["has"].get(name), getattr(target, name, None)) for name, each in tree["has"].items()}
        if _is_frozen(type(target)):
            made = object.__new__(type(target))
            for name, value in changed.items():
                object.__setattr__(made, name, value)
            self._made[tree["number"]] = made
            return made
        for name, value in changed.items():
            if getattr(target, name, None) is not value:
                setattr(target, name, value)
        return target

    def _dict(self, tree: Any, pristine: Any, target: dict[Any, Any]) -> dict[Any, Any]:
        was = {repr(key): each for key, each in pristine.get("dict", ())} if isinstance(pristine, dict) else {}
        rows = {}
        for frozen_key, each in tree["dict"]:
            key = self.build(frozen_key)
            rows[key] = self.carry(each, was.get(repr(frozen_key)), target[key]) if key in target else self.build(each)
        target.clear()
        target.update(rows)
        return target

    def _note(self, tree: Any, target: Any) -> None:
        """Parts that did not change may be meant elsewhere."""
        if not isinstance(tree, dict):
            return
        if "number" in tree:
            self._made[tree["number"]] = target
        if "has" in tree and not isinstance(target, Kept):
            for name, each in tree["has"].items():
                self._note(each, getattr(target, name, None))
        for kind in ("list", "tuple", "deque"):
            if kind in tree and _length(target) == len(tree[kind]):
                for each, now in zip(tree[kind], target, strict=True):
                    self._note(each, now)

    def build(self, tree: Any) -> Any:
        """Build an object; only our own classes and plain data."""
        if not isinstance(tree, dict):
            return tree
        if "same" in tree:
            if tree["same"] not in self._made:
                raise StateError(f"part {tree['same']} is referred to before its definition")
            return self._made[tree["same"]]
        if "kept" in tree:
            kept = self._kept(tree, None)
            if kept is not None:
                return kept
            raise StateError(f"the state contains a {tree['kept']}, which a recording cannot store; begin it at rest")
        made = self._built(tree)
        if "number" in tree:
            self._made[tree["number"]] = made
        return made

    def _built(self, tree: Any) -> Any:
        if "enum" in tree:
            kind = _class(tree["enum"])
            if not issubclass(kind, enum.Enum):
                raise StateError(f"{tree['enum']} is not an enumeration")
            return kind(self.build(tree["value"]))
        if "bytes" in tree:
            return bytes.fromhex(tree["bytes"])
        if "bytearray" in tree:
            return bytearray.fromhex(tree["bytearray"])
        if "tuple" in tree:
            return _of_tuple(tree, [self.build(each) for each in tree["tuple"]])
        if "dict" in tree:
            return {self.build(key): self.build(each) for key, each in tree["dict"]}
        if "deque" in tree:
            return deque((self.build(each) for each in tree["deque"]), tree.get("most"))
        if "array" in tree:
            return _numbers(tree)
        for name, kind in (("list", list), ("set", set), ("frozenset", frozenset)):
            if name in tree:
                return kind(self.build(each) for each in tree[name])
        if "object" in tree:
            made = object.__new__(_class(tree["object"]))
            self._made[tree["number"]] = made
            for name, each in tree["has"].items():
                object.__setattr__(made, name, self.build(each))
            return made
        raise StateError(f"a part that is nothing known: {str(tree)[:60]}")


def _numbers(tree: Any) -> Any:
    import numpy as np

    kind = np.dtype(str(tree["kind"]))
    if kind.kind not in "biuf":
        raise StateError(f"an array of {kind}: no numbers")
    return np.frombuffer(bytes.fromhex(tree["array"]), kind).reshape(tree["shape"]).copy()


def _length(value: object) -> int:
    return len(value) if isinstance(value, list | tuple | deque) else -1


def _of_tuple(tree: Any, parts: list[Any]) -> Any:
    return _class(tree["class"])._make(parts) if "class" in tree else tuple(parts)


def _class(name: str) -> Any:
    """A class of a pure package: those can touch neither file nor socket."""
    module, path = location_of(name)
    if not f"{module}.".startswith(OURS):
        raise StateError(f"{name}: no class of a state")
    try:
        found: Any = importlib.import_module(module)
        for part in path.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError) as error:
        raise StateError(f"{name}: this version has none ({error})") from error
    if not isinstance(found, type):
        raise StateError(f"{name} is not a class")
    return found
