"""What names mean inside one program: parameters, locals, global data, libraries, words.  Source: VAL 3 reference 2.5.2, L1018-1027."""

from dataclasses import dataclass

from gateway.pure.languages.val3.model import FAMILIES, FIELDS, WORDS, Application, Declaration, Parameter, ProgramText, Type, UserType
from gateway.pure.languages.val3.syntax import CompileFault, Consequence, Node

WORD_KINDS = {word.lower(): (kind, word) for kind, words in WORDS.items() for word in words}
KEYWORDS = frozenset(
    "begin end call return if elseif else endif while endwhile do until for to step endfor switch case break default endswitch "
    "taskcreate taskcreatesync and or xor true false".split()
)


@dataclass(slots=True)
class Value:
    """A checked expression.  `c`, `k`: the variable is c[k]; `whole`: its container, from `offset` on; `parts`: of a literal."""

    code: str
    type: Type
    node: Node
    c: str = ""
    k: str = ""
    whole: str = ""
    offset: str = "0"
    dims: int = 1
    indexed: bool = False
    local: bool = False  # it ends with its program
    start: str = ""  # of an array that was passed by reference: the place at which it begins, LocalPlace of a local one
    waits: bool = False
    parts: "list[Value | None] | None" = None


@dataclass(slots=True)
class Slot:
    """Where a parameter or local lies in the list of a frame."""

    index: int
    type: Type
    dims: int
    reference: bool = False
    whole: bool = False
    broken: bool = False  # its type is not there


@dataclass(slots=True)
class Scope:
    """Names of one program of one application.  `axes`: of the arm."""

    app: Application
    program: ProgramText
    slots: dict[str, Slot]
    size: int
    axes: int

    def variable(self, library: str, name: str, node: Node) -> Value:
        """A variable or a word.  CompileFault where nothing has that name."""
        if library:
            return self._public(library, name, node)
        if (slot := self.slots.get(name)) is not None:
            if slot.broken:
                raise Consequence
            return of_slot(slot, node)
        if name in self.program.lost or name in self.app.lost:
            raise Consequence
        if (declared := self.app.data.get(name)) is not None:
            if declared.broken:
                raise Consequence
            return of_container(f"g_{name}", declared, node)
        if name.lower() in ("true", "false"):
            return Value(name.lower().capitalize(), "bool", node)
        if name.lower() in ("world", "flange"):
            kind = "frame" if name.lower() == "world" else "tool"
            return Value(f"{name.lower()}[0]", kind, node, c=name.lower(), k="0", whole=name.lower())
        if (word := WORD_KINDS.get(name.lower())) is not None:
            return Value(repr(word[1]), word[0], node)
        if self.app.lost_data:
            raise Consequence
        raise CompileFault(f"'{name}' : data expected", node.start + 1)

    def _public(self, library: str, name: str, node: Node) -> Value:
        if library not in self.app.libraries:
            raise CompileFault(f"'{library}' : undefined library", node.start + 1)
        interface = self.app.interfaces.get(library)
        declared = interface.data.get(name) if interface is not None else None
        if library in self.app.lost_libraries or (declared is not None and declared.broken):
            raise Consequence
        if declared is None and interface is not None and (interface.lost_data or name in interface.lost):
            raise Consequence
        if declared is None or not declared.public:
            raise CompileFault(f"'{library}:{name}' : data expected", node.start + 1)
        return of_container(f"lib_data({library!r},{name!r})", declared, node)

    def field(self, base: Value, name: str, node: Node) -> Value:
        """base.name."""
        if isinstance(base.type, UserType):
            declared = base.type.fields.get(name)
            if declared.broken if declared is not None else base.type.partial:
                raise Consequence
            if declared is None:
                raise CompileFault(f"'{name}' : invalid name", node.end - len(name) + 1)
            made = of_container(f"{base.code}.u_{name}", declared, node)
            made.local, made.waits = False, base.waits  # containers inside local variables may be resized (L4147)
            if not base.c:
                made.c = made.k = made.whole = ""
            return made
        found = self.fields(base.type)
        key = name if name in found else name.lower()
        if key not in found:
            raise CompileFault(f"'{name}' : invalid name", node.end - len(name) + 1)
        made = Value(f"{base.code}.{key}", found[key], node, local=base.local, waits=base.waits)
        if base.c:
            made.c, made.k = base.code, repr(key)
        return made

    def fields(self, kind: Type) -> dict[str, Type]:
        """Fields of a structured type."""
        if kind == "joint":
            return {f"j{n}": "num" for n in range(1, self.axes + 1)}
        if kind == "config" and self.axes == FAMILIES["rs"]:
            return {"shoulder": "shoulder"}  # a SCARA has no other (L5253)
        return dict(FIELDS.get(kind, {})) if isinstance(kind, str) else {}


def of_slot(slot: Slot, node: Node) -> Value:
    """A parameter or local variable."""
    base = f"v[{slot.index}]"
    if slot.reference and not slot.whole:
        key = f"v[{slot.index + 1}]"
        return Value(f"{base}[{key}]", slot.type, node, c=base, k=key, whole=base, offset=key, indexed=True)
    if slot.reference and slot.dims == 1:
        key = f"v[{slot.index + 1}]"
        return Value(f"{base}[{key}]", slot.type, node, c=base, k=key, whole=base, offset=key, start=key)
    made = Value(f"{base}[0]", slot.type, node, c=base, k="0", whole=base, dims=slot.dims, local=not slot.reference)
    return made


def of_container(code: str, declared: Declaration, node: Node) -> Value:
    """Global data or the field of a user type."""
    return Value(f"{code}[0]", declared.type, node, c=code, k="0", whole=code, dims=declared.dims)


def slots_of(program: ProgramText) -> tuple[dict[str, Slot], int]:
    """Parameters first, then locals."""
    found: dict[str, Slot] = {}
    at = 0
    for parameter in program.parameters:
        found[parameter.name] = Slot(at, parameter.type, parameter.dims, parameter.reference, parameter.whole, parameter.broken)
        at += width(parameter)
    for local in program.locals:
        found[local.name] = Slot(at, local.type, local.dims, broken=local.broken)
        at += 1
    return found, at


def width(parameter: Parameter) -> int:
    """Slots of a parameter: container and place where one value or part of an array is passed."""
    return 2 if parameter.reference and (not parameter.whole or parameter.dims == 1) else 1
