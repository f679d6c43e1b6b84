"""Loads applications from the disk: user types, interfaces of libraries, checked and translated programs, data."""

from dataclasses import dataclass, field

from gateway.pure.languages.base.faults import Faults, SourceFault
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.val3.disk import Disk, PathFault, application_of
from gateway.pure.languages.val3.files import Reader
from gateway.pure.languages.val3.links import declarations
from gateway.pure.languages.val3.model import BUILT_IN, FAMILIES, Application, Declaration, Type, Use, UserType
from gateway.pure.languages.val3.program_code import Code
from gateway.pure.languages.val3.references import check_references
from gateway.pure.languages.val3.sealed import SealFault, library_of
from gateway.pure.languages.val3.translate import ProgramTranslator
from gateway.pure.languages.val3.value_checks import check_values
from motion.val3.mdesc import TOO_LARGE, matching

DEEPEST = 20  # user types one in the other
UNIT = "val3-unit"  # faults of that kind: length units that differ
NOMINAL = 100.0  # %
ABOUT = 0.1  # so far accel and decel may be off the square of the speed


def _percent(text: str | None) -> float:
    """Return a field of an mdesc; an invalid number is reported elsewhere."""
    try:
        return NOMINAL if text is None else float(text)
    except ValueError:
        return NOMINAL


@dataclass(slots=True)
class Loaded:
    """One application, checked.  `codes`: translated programs, those with faults are missing."""

    app: Application
    faults: Faults
    codes: dict[str, Code] = field(default_factory=dict)

    def logged(self, fault: SourceFault) -> str:
        """As a controller writes it to its log: files of the application itself without its folder."""
        file = fault.position.file.removeprefix(f"{self.app.path}/") if self.app.path else fault.position.file
        return f"(File {file}-line {fault.position.line}) {fault.text}"


class Loader:
    """Everything read from one disk, each application once."""

    def __init__(self, disk: Disk, axes: int = 6, *, family: str = "rx", strict: bool = False) -> None:
        self.disk, self.axes, self.family, self.strict = disk, axes, family, strict
        self._read: dict[str, tuple[Application | None, Faults]] = {}
        self._types: dict[str, UserType] = {}
        self._open_types: list[str] = []
        self._loaded: dict[str, Loaded | None] = {}
        self._linking: list[str] = []
        self._linked: set[str] = set()

    # ---- reading ---------------------------------------------------------------------------------------------------------
    def read(self, folder: str, name: str) -> tuple[Application | None, Faults]:
        """The files of an application, once."""
        key = f"{folder}/{name}".lower()
        if key not in self._read:
            faults = Faults(texts=True)
            self._read[key] = (Reader(self.disk, faults).application(folder, name), faults)
            app = self._read[key][0]
            if app is not None:
                self._link_types(app, faults)
        return self._read[key]

    def _there(self, folder: str, name: str) -> bool:
        return self.disk.read(Application(name, folder).project) is not None

    def forget(self, folder: str, name: str) -> None:
        """The files have changed."""
        key = f"{folder}/{name}".lower()
        self._read.pop(key, None)
        self._loaded.pop(key, None)
        self._linked.discard(key)

    def _link_types(self, app: Application, faults: Faults) -> None:
        for use in app.types.values():
            found = None if use.name in app.lost_libraries else self._user_type(app, use, faults)
            if found is not None:
                app.resolved[use.name] = found
                _compare_units(app, found.millimetres, f"user type '{use.name}'", use, faults)
        for declared in app.data.values():
            self._resolve(app, declared, faults)
        for program in app.programs.values():
            for parameter in program.parameters:
                kind = self._type(app, parameter.type_name)
                if kind is None and parameter.type_name not in app.types:
                    faults.error(
                        "val3-type",
                        Position(program.file, parameter.line, parameter.column),
                        f"'{parameter.name}' : invalid type ({parameter.type_name})",
                    )
                parameter.type, parameter.broken = kind if kind is not None else "num", kind is None
            for local in program.locals:
                self._resolve(app, local, faults)

    def _resolve(self, app: Application, declared: Declaration, faults: Faults) -> None:
        kind = self._type(app, declared.type_name)
        if kind is None and declared.type_name not in app.types:  # one of those is named where it is declared
            faults.error("val3-type", declared.place, f"'{declared.name}' : invalid type ({declared.type_name})")
        declared.type, declared.broken = kind if kind is not None else "num", kind is None

    @staticmethod
    def _type(app: Application, name: str) -> Type | None:
        return name if name in BUILT_IN else app.resolved.get(name)

    def _user_type(self, app: Application, use: Use, faults: Faults) -> UserType | None:
        name, path, place = use.name, use.path, _place(app, use)
        try:
            folder, own = application_of(path, app.path)
        except PathFault as fault:
            faults.error("val3-type", place, f"'{name}' : {fault}")
            return None
        key = f"{folder}/{own}".lower()
        if key in self._types:
            _pass_on(self.read(folder, own)[1], faults)
            return self._types[key]
        if key in self._open_types or len(self._open_types) > DEEPEST:
            faults.error("val3-type", place, f"'{name}' : the type is made of itself")
            return None
        self._open_types.append(key)
        made, inside = self.read(folder, own)
        self._open_types.pop()
        if self._there(folder, own):  # faults of its files and their content
            _pass_on(inside, faults)
        if made is None:
            faults.error("val3-type", place, f"'{name}' : there is no application {path}")
            return None
        kind = UserType(name, key, millimetres=made.millimetres)
        kind.fields = {each.name: each for each in made.data.values() if each.public}
        kind.partial = made.lost_data or bool(made.lost)
        self._types[key] = kind
        return kind

    def user_types(self) -> dict[str, UserType]:
        """All user types by the path of what defines them."""
        return self._types

    # ---- loading ---------------------------------------------------------------------------------------------------------
    def load(self, folder: str, name: str) -> Loaded | None:
        """Load it with interfaces and programs; None: unknown application."""
        key = f"{folder}/{name}".lower()
        if key in self._loaded:
            return self._loaded[key]
        app, read_faults = self.read(folder, name)
        if app is None:
            made = Loaded(Application(name, folder), read_faults) if len(read_faults) else None
            self._loaded[key] = made
            return made
        faults = Faults(texts=True)
        _pass_on(read_faults, faults)
        self._interfaces(app, faults)
        made = Loaded(app, faults)
        self._loaded[key] = made
        for program in app.programs.values():
            code = ProgramTranslator(app, program, faults, self.axes, strict=self.strict).translate()
            if code is not None:
                made.codes[program.name] = code
        self._families(app, faults)
        self._speeds(app, faults)
        check_values(app, faults)
        check_references(app, faults)
        return made

    def _families(self, app: Application, faults: Faults) -> None:
        for declared in app.data.values():
            if declared.family and self.family and declared.family != self.family:
                text = (
                    f"'{declared.name}' : made for an {declared.family.upper()} arm, this is an {self.family.upper()}; using it is error 81"
                )
                faults.warning("val3-family", declared.place, text)

    def _speeds(self, app: Application, faults: Faults) -> None:
        """Above the nominal speed, accel and decel that do not go with it (L5654)."""
        for declared in (inner for each in app.data.values() for inner in declarations(each) if inner.type_name == "mdesc"):
            for value in declared.values:
                vel, accel, decel = (_percent(value.attributes.get(name)) for name in ("vel", "accel", "decel"))
                if not NOMINAL < vel <= TOO_LARGE:
                    continue
                rule = matching(vel).accel
                if max(abs(accel - rule), abs(decel - rule)) > ABOUT * rule:
                    text = (
                        f"'{declared.name}' : vel {vel:g} % does not match accel and decel of {rule:g} %, not {accel:g} % and {decel:g} %"
                    )
                    faults.warning("val3-speed", declared.place, text)

    def _interfaces(self, app: Application, faults: Faults) -> None:
        """Libraries are only looked at for what they show (L3927)."""
        for use in app.libraries.values():
            if not use.path:
                app.interfaces[use.name] = None
                continue
            try:
                folder, own = library_of(self.disk, use.path, app.path, use.password)
            except (PathFault, SealFault) as fault:
                faults.error("val3-library", _place(app, use), f"library '{use.name}': {fault}")
                app.lost_libraries.add(use.name)
                continue
            found, inside = self.read(folder, own)
            for each in inside if self._there(folder, own) else ():  # the library cannot be loaded (12), the application can
                faults.warning(each.id, each.position, f"library '{use.name}': {each.text}")
            app.interfaces[use.name] = found
            if found is None:
                faults.error("val3-library", _place(app, use), f"library '{use.name}': there is no application {use.path}")
                app.lost_libraries.add(use.name)
                continue
            _compare_units(app, found.millimetres, f"library '{use.name}'", use, faults)
            if ring := self._ring(app, found, [app.project]):
                faults.error("val3-library", _place(app, use), f"libraries in a ring: {' -> '.join(ring)}")
            self._rings_below(found, {app.project}, use.name, faults)

    def _rings_below(self, app: Application, known: set[str], name: str, faults: Faults) -> None:
        """Rings of libraries alone: they cannot be loaded (12), the application can."""
        if app.project in known:
            return
        known.add(app.project)
        for use in app.libraries.values():
            inner = self._library(app, use)
            if inner is None or inner.project in known:
                continue
            ring = self._ring(app, inner, [app.project])
            if ring:
                text = f"library '{name}': libraries in a ring: {' -> '.join(ring)}"
                faults.warning("val3-library", _place(app, use), text)
                known.update(ring)
            self._rings_below(inner, known, name, faults)

    def _library(self, app: Application, use: Use) -> Application | None:
        try:
            return self.read(*application_of(use.path, app.path))[0]
        except PathFault:
            return None

    def _ring(self, app: Application, found: Application, way: list[str]) -> list[str]:
        if found.project == app.project:
            return [*way, found.project]
        if found.project in way:
            return []
        for use in found.libraries.values():
            inner = self._library(found, use)
            if inner is not None and (ring := self._ring(app, inner, [*way, found.project])):
                return ring
        return []


def _place(app: Application, use: Use) -> Position:
    return Position(app.project, use.line, use.column)


def _compare_units(app: Application, millimetres: bool, what: str, use: Use, faults: Faults) -> None:
    """A warning, which is a popup when the application starts and code 1 of libLoad (L532-538)."""
    if millimetres != app.millimetres:
        names = {True: "mm", False: "inch"}
        text = f"{what}: its length unit is {names[millimetres]}, that of {app.name} is {names[app.millimetres]}"
        faults.warning(UNIT, _place(app, use), text)


def _pass_on(found: Faults, faults: Faults) -> None:
    for fault in found:
        (faults.error if fault.severity.value == "error" else faults.warning)(fault.id, fault.position, fault.text)


def family_of_arm(axes: int) -> str:
    """rx for six axes, rs for four, "" for others."""
    return next((family for family, count in FAMILIES.items() if count == axes), "")
