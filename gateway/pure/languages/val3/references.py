"""The frame or tool to which a value is linked, as named in files: `fatherId="fBase[2]"`, of a library `fatherId="cell:fPallet[1,0]"`.

A library is in memory only after libLoad, and another one may replace it: values linked to its data are joined again with each load.
Until then, and where nothing has that name, the use of the value is a run-time error (80, 82; L3674-3676), never a position in world.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.val3.links import declarations
from gateway.pure.languages.val3.model import Application, Declaration, Initial, UserType
from gateway.pure.languages.val3.values import Container, FrameV, Grid, PointV, ToolV, UserV

NAMED = re.compile(r"(?:(\w+):)?(\w+)(?:\[(.*)\])?", re.ASCII)
INSIDE = re.compile(r"(?<=\])\.(?=\w+\[)", re.ASCII)  # pal[0].fBase[0]
NOT_LOADED, OUT_OF_SCOPE = 80, 82
HANGING = ("frame", "tool", "point")


@dataclass(frozen=True, slots=True)
class Reference:
    """library: "" for the application itself; inner: fields with their indices, of a value of a user type."""

    library: str
    name: str
    index: str
    inner: tuple[tuple[str, str], ...] = ()

    def of(self, data: Mapping[str, Container], kind: type[FrameV] | type[ToolV]) -> FrameV | ToolV | None:
        """The frame or tool of that name; None: there is none."""
        found = element(data.get(self.name), self.index)
        for field, index in self.inner:
            found = element(getattr(found, f"u_{field}", None), index)
        return found if isinstance(found, kind) else None


def reference_of(text: str) -> Reference | None:
    """As a file writes it."""
    first, *rest = (NAMED.fullmatch(part) for part in INSIDE.split(text.strip()))
    if first is None or any(each is None or each.group(1) for each in rest):
        return None
    inner = tuple((each.group(2), each.group(3) or "") for each in rest if each is not None)
    return Reference(first.group(1) or "", first.group(2), first.group(3) or "", inner)


def element(container: Container | None, index: str) -> object:
    """container[index], without an index its first value; None: it has none."""
    if isinstance(container, dict):
        return container.get(index.strip('"'))
    parts = [part.strip() for part in (index or "0").split(",")]
    if container is None or not all(part.isascii() and part.isdecimal() for part in parts):
        return None
    places = [int(part) for part in parts]
    if isinstance(container, Grid):
        inside = len(places) == len(container.dims) and all(n < size for n, size in zip(places, container.dims, strict=True))
        return container.flat[container.at(*map(float, places))] if inside else None
    return container[places[0]] if len(places) == 1 and places[0] < len(container) else None


def kind_for(value: FrameV | ToolV | PointV) -> type[FrameV] | type[ToolV]:
    """Tools hang on tools, all else on frames."""
    return ToolV if isinstance(value, ToolV) else FrameV


def missing(kind: type[FrameV] | type[ToolV], code: int, text: str) -> FrameV | ToolV:
    """A frame or tool for a name that leads nowhere; using it is the error."""
    made = kind()
    made.lost = (code, text)
    return made


def written(name: str, container: Container, wanted: FrameV | ToolV) -> str:
    """How a file names a value of a container, or of a user type in it; "" where it does not have it."""
    values: Iterable[tuple[object, object]]
    if isinstance(container, Grid):
        values = ((",".join(map(str, _indices(place, container.dims))), each) for place, each in enumerate(container.flat))
    else:
        values = container.items() if isinstance(container, dict) else enumerate(container)
    for key, each in values:
        if each is wanted:
            return f"{name}[{key}]"
        for field in each.type.fields if isinstance(each, UserV) else ():
            if found := written(f"{name}[{key}].{field}", getattr(each, f"u_{field}"), wanted):
                return found
    return ""


def _indices(place: int, dims: tuple[int, ...]) -> list[int]:
    found = []
    for size in reversed(dims):
        place, index = divmod(place, size)
        found.append(index)
    return found[::-1]


# ---- at load ---------------------------------------------------------------------------------------------------------------


def check_references(app: Application, faults: Faults) -> None:
    """Names that lead nowhere: a warning each, because the application runs until it uses the value."""
    for declared in app.data.values():
        for inner, text, value in _given(declared):
            if why := _wrong(app, inner, text):
                faults.warning(
                    "val3-reference", Position(declared.file, value.line, value.column), f"'{declared.name}' : fatherId {text!r}: {why}"
                )

    fathers = _fathers(app)
    for place, (_, value) in fathers.items():
        if _in_ring(fathers, place):
            name, key = place
            text = f"'{name}' : {name}[{key}] refers to itself; using it is error 165"
            faults.warning("val3-reference", Position(app.data[name].file, value.line, value.column), text)


Named = tuple[str, str]  # name and index


def _fathers(app: Application) -> dict[Named, tuple[Named, Initial]]:
    """Frames and tools of the application that hang on others of it; the value of each."""
    found: dict[Named, tuple[Named, Initial]] = {}
    for declared in app.data.values():
        if declared.type not in ("frame", "tool") or declared.name in ("world", "flange"):
            continue
        for value in declared.values:
            reference = reference_of(value.attributes.get("fatherId", ""))
            if reference is not None and not reference.library and not reference.inner:
                found[declared.name, value.key] = (reference.name, reference.index or "0"), value
    return found


def _in_ring(fathers: Mapping[Named, tuple[Named, Initial]], place: Named) -> bool:
    """Whether the way up leads back to it."""
    here = place
    for _ in fathers:
        if here not in fathers:
            return False
        here, _ = fathers[here]
        if here == place:
            return True
    return False


def _given(declared: Declaration) -> Iterator[tuple[Declaration, str, Initial]]:
    for inner in declarations(declared):
        if inner.type_name in HANGING:
            yield from ((inner, text, each) for each in inner.values if (text := each.attributes.get("fatherId", "")))


def _wrong(app: Application, declared: Declaration, text: str) -> str:
    wanted, reference = ("tool" if declared.type_name == "tool" else "frame"), reference_of(text)
    if reference is None:
        return f"the name of a {wanted} is expected"
    if not reference.library and not reference.inner and reference.name == ("flange" if wanted == "tool" else "world"):
        return ""
    data = app.data
    if reference.library:
        if reference.library not in app.libraries:
            return f"there is no library {reference.library}"
        interface = app.interfaces.get(reference.library)
        if interface is None:
            return ""  # its path is given by libLoad
        data = {name: each for name, each in interface.data.items() if each.public}
    found = last = data.get(reference.name)
    for field, _ in reference.inner:
        last = last.type.fields.get(field) if last is not None and isinstance(last.type, UserType) else None
    if found is None or last is None or last.type != wanted:
        return f"there is no {'public ' if reference.library else ''}{wanted} of that name"
    return "" if _inside(found, reference.index) else "it has no such element"


def _inside(declared: Declaration, index: str) -> bool:
    if declared.dims == 0:
        return any(each.key == index.strip('"') for each in declared.values)
    parts = [part.strip() for part in (index or ",".join("0" for _ in declared.sizes)).split(",")]
    digits = len(parts) == declared.dims and all(part.isascii() and part.isdecimal() for part in parts)
    return digits and all(int(part) < size for part, size in zip(parts, declared.sizes, strict=True))
