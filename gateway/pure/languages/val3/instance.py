"""One application in memory: its data, its programs ready to run, the libraries of its identifiers."""

from collections.abc import Callable
from dataclasses import dataclass, field

from gateway.pure.languages.val3.controller import Controller
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.initial_values import Surroundings, container_of, default
from gateway.pure.languages.val3.loader import Loaded
from gateway.pure.languages.val3.model import Declaration, ProgramText, UserType
from gateway.pure.languages.val3.program_code import Code
from gateway.pure.languages.val3.references import (
    NOT_LOADED,
    OUT_OF_SCOPE,
    Reference,
    element,
    kind_for,
    missing,
    reference_of,
)
from gateway.pure.languages.val3.scope import slots_of
from gateway.pure.languages.val3.sockets import has_sockets
from gateway.pure.languages.val3.tasks import Step, bytes_of
from gateway.pure.languages.val3.values import Container, FrameV, Grid, PointV, ToolV, UserV, mark_local

PLAIN: dict[str, object] = {"num": 0.0, "bool": False, "string": ""}


@dataclass(eq=False)
class Program:
    """A program of an instance; its steps are made when it is first called."""

    owner: "Instance"
    text: ProgramText
    code: Code
    bytes: int = 0
    sockets: tuple[int, ...] = ()  # slots of its own variables that are sio or have some inside
    _steps: list[Step] | None = None

    def __post_init__(self) -> None:
        self.bytes = bytes_of(self.text)
        slots, _ = slots_of(self.text)
        self.sockets = tuple(slot.index for slot in slots.values() if not slot.reference and has_sockets(slot.type))

    @property
    def name(self) -> str:
        """As declared."""
        return self.text.name

    @property
    def home(self) -> Surroundings:
        """Of its application."""
        return self.owner.home

    def steps(self) -> list[Step]:
        """One function a step."""
        if self._steps is None:
            own = dict(self.owner.names)
            exec(compile(self.code.text, self.text.file, "exec"), own)
            found = [own.get(f"L{at}") for at in range(self.code.steps)]
            watched = self.owner.machine.watched
            made = (step if watched is None or not callable(step) else watched(self, at, step) for at, step in enumerate(found))
            self._steps = [step if callable(step) else _nothing for step in made]
        return self._steps

    def fresh(self) -> list[object]:
        """Its local variables as a call begins; single numbers, bools and strings without the way through their declarations."""
        made: list[object] = []
        for local in self.text.locals:
            plain = PLAIN.get(local.type) if isinstance(local.type, str) and local.sizes == (1,) and not local.values else None
            container: Container = [plain] if plain is not None else container_of(local, self.home, linked=False)
            if isinstance(local.type, UserType) or local.type in ("frame", "tool", "point"):
                mark_local(container)
            if isinstance(container, Grid):
                container.local = True
            made.append(container)
        return made

    def line_of(self, pc: int) -> int:
        """Line of a step."""
        return self.code.lines[pc] if 0 <= pc < len(self.code.lines) else self.code.last_line

    def step_at(self, line: int) -> int:
        """Return the first step at or after a line."""
        for at, own in enumerate(self.code.lines):
            if own >= line:
                return self.code.targets[at]
        return self.code.targets[-1]


def _nothing(_: list[object]) -> int:
    raise Rte(61, "a step that is none")


@dataclass(eq=False)
class Instance:
    """`prefix`: "" for the application, else the identifier it was first loaded under."""

    machine: Controller
    loaded: Loaded
    prefix: str = ""
    data: dict[str, Container] = field(default_factory=dict)
    programs: dict[str, Program] = field(default_factory=dict)
    libraries: "dict[str, Instance | None]" = field(default_factory=dict)
    names: dict[str, object] = field(default_factory=dict)
    path: str = ""
    _abroad: "list[tuple[Reference, FrameV | ToolV | PointV, str]]" = field(default_factory=list)  # values that hang on libraries
    _joined: "dict[int, FrameV | ToolV]" = field(default_factory=dict)  # on what they hang through join(), by their id

    def __post_init__(self) -> None:
        app = self.loaded.app
        self.libraries = dict.fromkeys(app.libraries)
        for name, declared in app.data.items():
            self.data[name] = container_of(declared, self.home, linked=True)
        for name, declared in app.data.items():  # now that all frames and tools are there
            self._fathers(declared, self.data[name])
        self.programs = {name: Program(self, app.programs[name], code) for name, code in self.loaded.codes.items()}

    def _fathers(self, declared: Declaration, container: Container) -> None:
        """Joins what its file names, inside user types, too."""
        for value in declared.values:
            made = element(container, value.key)
            if isinstance(made, UserV):
                for name, inner in value.fields.items():
                    if name in made.type.fields:
                        self._fathers(inner, getattr(made, f"u_{name}"))
            elif (text := value.attributes.get("fatherId")) is not None:
                self.hang(text, made)

    def hang(self, text: str, value: object) -> None:
        """Joins a value with what its file names."""
        if not isinstance(value, FrameV | ToolV | PointV):
            return
        reference, kind = reference_of(text), kind_for(value)
        if not text.strip():  # saved without a reference
            value["father"] = None
        elif reference is not None and reference.library in self.libraries:
            self._abroad.append((reference, value, text))
            value["father"] = missing(kind, NOT_LOADED, text)
        elif reference is not None and not reference.library and not reference.inner and reference.name in ("world", "flange"):
            root = getattr(self.home, reference.name)
            value["father"] = root if isinstance(root, kind) else missing(kind, OUT_OF_SCOPE, text)
        else:
            found = reference.of(self.data, kind) if reference is not None and not reference.library else None
            value["father"] = found if found is not None else missing(kind, OUT_OF_SCOPE, text)

    def join(self, identifier: str) -> None:
        """Join the values linked to a loaded library's data, unless a program has linked them elsewhere."""
        library = self.libraries[identifier]
        assert library is not None
        public = {name: each for name, each in library.data.items() if library.loaded.app.data[name].public}
        for reference, value, text in self._abroad:
            if reference.library == identifier and (value.father is self._joined.get(id(value)) or (value.father and value.father.lost)):
                found = reference.of(public, kind_for(value))
                made = found if found is not None else missing(kind_for(value), OUT_OF_SCOPE, text)
                value["father"] = self._joined[id(value)] = made

    @property
    def home(self) -> Surroundings:
        """Axes and roots."""
        return self.machine

    @property
    def stack(self) -> int:
        """Bytes of a task."""
        return self.loaded.app.stack

    def library(self, identifier: str) -> "Instance":
        """What is loaded under an identifier; 80."""
        found = self.libraries.get(identifier)
        if found is None:
            raise Rte(80, f"library {identifier} is not loaded")
        return found

    def public_data(self, identifier: str, name: str) -> Container:
        """identifier:name; 80 where the library has no such public datum of the same kind."""
        found = self.library(identifier)
        declared = found.loaded.app.data.get(name)
        interface = self.loaded.app.interfaces.get(identifier)
        expected = interface.data.get(name) if interface is not None else None
        if declared is None or not declared.public:
            raise Rte(80, f"{identifier}:{name} does not exist")
        if expected is not None and (
            (declared.type is not expected.type and declared.type != expected.type) or declared.dims != expected.dims
        ):
            raise Rte(80, f"{identifier}:{name} is of another type")
        return found.data[name]

    def public_program(self, identifier: str, name: str) -> Program:
        """identifier:name(); 80."""
        program = self.library(identifier).programs.get(name)
        if program is None or not program.text.public:
            raise Rte(80, f"{identifier}:{name}() does not exist")
        interface = self.loaded.app.interfaces.get(identifier)
        expected = interface.programs.get(name) if interface is not None else None
        if expected is not None and [(p.type, p.reference, p.whole, p.dims) for p in expected.parameters] != [
            (p.type, p.reference, p.whole, p.dims) for p in program.text.parameters
        ]:
            raise Rte(80, f"{identifier}:{name}() has other parameters")
        return program

    def maker(self, kind: str, linked: bool = True) -> Callable[[], object]:
        """Makes default values of a type; `type:PATH` for a user type.  linked: frames, tools and points hang on world or flange."""
        if kind.startswith("type:"):
            found = self.machine.loader.user_types()[kind[5:]]
            return lambda: default(found, self.home)
        return lambda: default(kind, self.home, linked=linked)
