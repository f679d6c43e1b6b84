"""Values as they begin: defaults of types, initial values of files, literals of programs."""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.model import FIELDS, WORDS, Declaration, Initial, Type, UserType
from gateway.pure.languages.val3.values import (
    AioV,
    Collection,
    ConfigV,
    Container,
    DioV,
    FrameV,
    Grid,
    JointV,
    LinkV,
    MdescV,
    PointV,
    ScreenV,
    SioV,
    Structure,
    ToolV,
    TrsfV,
    UserV,
    cut,
)


class Surroundings(Protocol):
    """What defaults depend on: the arm's axes, the roots of frames and tools."""

    axes: int
    world: FrameV
    flange: ToolV


def default(kind: Type, home: Surroundings, linked: bool = False) -> object:
    """The value of a new variable; `linked`: global data, whose frames hang on world and tools on flange (L4825, L4923)."""
    if isinstance(kind, UserType):
        made = UserV(kind)
        for name, declared in kind.fields.items():
            setattr(made, f"u_{name}", container_of(declared, home, linked=False))
        return made
    match kind:
        case "num":
            return 0.0
        case "bool":
            return False
        case "string":
            return ""
        case "joint":
            return JointV(count=home.axes)
        case "frame":
            return FrameV(home.world if linked else None)
        case "tool":
            tool = ToolV(home.flange if linked else None)
            tool.gripper.link = "valve1"  # of local ones, too: they lack the base tool alone (L4923)
            return tool
        case "point":
            return PointV(home.world if linked else None)
    return MAKERS[kind]()


MAKERS: dict[str, Callable[[], object]] = {
    "trsf": TrsfV,
    "config": ConfigV,
    "mdesc": MdescV,
    "dio": DioV,
    "aio": AioV,
    "sio": SioV,
    "screen": ScreenV,
    "shoulder": lambda: "ssame",
    "elbow": lambda: "esame",
    "wrist": lambda: "wsame",
    "blend": lambda: "off",
}


def container_of(declared: Declaration, home: Surroundings, linked: bool) -> Container:
    """A container with its initial values.  Raises Rte 70 for a value its type does not have."""
    if declared.dims == 0:
        found = Collection()
        for value in declared.values:
            found[value.key] = initial(declared, value, home, linked)
        return found
    flat = [default(declared.type, home, linked) for _ in range(math.prod(declared.sizes))]
    if declared.family:
        for one in flat:
            if isinstance(one, JointV | PointV):
                one.family = declared.family
    grid = Grid(declared.sizes, flat)
    for value in declared.values:
        place = grid.at(*(float(part) for part in value.key.split(",")))
        flat[place] = initial(declared, value, home, linked)
    return flat if declared.dims == 1 else grid


def initial(declared: Declaration, value: Initial, home: Surroundings, linked: bool) -> object:
    """One value as the file writes it."""
    made = default(declared.type, home, linked)
    given = value.attributes
    match made:
        case bool():
            return BOOLS.get(given.get("value", "false").lower(), False)
        case float():
            return number(given.get("value", "0"))
        case str() if declared.type == "string":
            return cut(given.get("value", ""))
        case UserV():
            for name, own in value.fields.items():
                if name in made.type.fields:
                    target = made.type.fields[name]
                    filled = Declaration(name, target.type_name, own.dims, own.sizes, True, own.values, own.file, own.line, target.type)
                    filled.family = own.family
                    setattr(made, f"u_{name}", container_of(filled, home, False))
            return made
        case LinkV():
            made.link = given.get("link") or None
            return made
        case Structure():
            fill(made, given)
            if declared.family and isinstance(made, JointV | PointV):
                made.family = declared.family
    return made


BOOLS = {"true": True, "1": True, "false": False, "0": False}
ALIASES = {"tmax": "tvel", "rmax": "rvel", "open": "otime", "close": "ctime", "ioOpen": "otime", "ioClose": "ctime"}


def fill(made: Structure, given: dict[str, str]) -> None:
    """Attributes into fields: x..rz go to the trsf, shoulder .. wrist to the configuration."""
    parts = [made]
    for name in ("trsf", "config"):
        inner = getattr(made, name, None)
        if isinstance(inner, Structure):
            parts.append(inner)
    for name, text in given.items():
        name = ALIASES.get(name, name) if isinstance(made, MdescV | ToolV) else name
        if name == "ioLink" and isinstance(made, ToolV):
            made.gripper.link = text or None
        for part in parts:
            if name in part.names() and name not in ("father", "trsf", "config", "gripper"):
                setattr(part, name, word(name, text) if name in WORDS else number(text))


def word(kind: str, text: str) -> str:
    """A word of an enumeration in any case."""
    for known in WORDS[kind]:
        if known.lower() == text.lower():
            return known
    raise Rte(70, f"{kind} {text!r}: there are {', '.join(WORDS[kind])}")


def number(text: str) -> float:
    """A number of a file; 70 for anything that is none."""
    try:
        value = float(text.strip() or "0")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise Rte(70, f"{text!r} is not a number")
    return value


def literal(kind: Type, parts: Iterable[object], home: Surroundings) -> Structure:
    """{a, b, ...}: None is an empty field, 0 (L986)."""
    made = default(kind, home)
    assert isinstance(made, Structure)
    for name, part in zip(fields_of(kind, home.axes), parts, strict=False):
        if part is None:
            part = empty(FIELDS.get(str(kind), {}).get(name, "num"), home)
        mine = getattr(made, name)
        if isinstance(mine, Structure):
            mine.set(part)
        else:
            setattr(made, name, part)
    return made


def empty(kind: str, home: Surroundings) -> object:
    """What an empty field means."""
    return default(kind, home)


def fields_of(kind: Type, axes: int) -> Iterator[str]:
    """Names of the fields of a structured type, in their order."""
    if kind == "joint":
        yield from JointV.FIELDS[:axes]
    elif isinstance(kind, str):
        yield from FIELDS.get(kind, {})
