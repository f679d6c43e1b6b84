"""Reads .pjx, .dtx and .pgx files.  Source: S8 note N01 and its corrections; faults name the file and its line."""

from typing import Protocol

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.val3.disk import Disk, PathFault, resolve
from gateway.pure.languages.val3.model import (
    BUILT_IN,
    MOST_IN_FILES,
    MOST_VALUES,
    Application,
    Declaration,
    Initial,
    Parameter,
    ProgramText,
    Use,
)
from gateway.pure.languages.val3.unread import unread
from gateway.pure.languages.val3.xmltree import Element, XmlFault, parse_xml

ROOT = "http://www.staubli.com/robotics/VAL3/"
LONGEST_FILE = 16 << 20


class Place(Protocol):
    """An element, or what was made of it."""

    line: int
    column: int


def is_name(text: str) -> bool:
    """Characters a..zA..Z0..9_, first a letter (L1016)."""
    return bool(text) and text[0].isalpha() and is_program_name(text)


def is_program_name(text: str) -> bool:
    """Programs of real controllers begin with _ too (AX-991)."""
    return bool(text) and text.isascii() and not text[0].isdigit() and text.replace("_", "a").isalnum()


class Reader:
    """Reads the files of one application; all faults are collected."""

    def __init__(self, disk: Disk, faults: Faults) -> None:
        self.disk, self.faults = disk, faults
        self.missing: list[Element] = []  # of the last file: elements with a name that nothing reads

    def application(self, folder: str, name: str) -> Application | None:
        """Return the application; None without a readable project file."""
        made = Application(name, folder)
        root = self._root(made.project, "Project", "Project/3")
        if root is None:
            return None
        if not self._head(made, root):
            return None
        self._uses(made, root)
        for kind, reader in (("Database", self._data), ("Programs", self._programs)):
            for listed in (each for group in root.all(kind) for each in group.children):
                if path := self._file(made, listed):
                    reader(made, path)
                else:
                    _lose(made, kind)
        return made

    # ---- the project -----------------------------------------------------------------------------------------------------
    def _head(self, made: Application, root: Element) -> bool:
        head = root.first("Parameters")
        if head is None:
            return True
        made.version = head.get("version")
        if made.version[:2].lower() in ("s3", "s4", "s5", "s6"):
            self._say(made.project, head, f"the application was written by {made.version}; s7 and s8 are read, s6 and older are not")
            return False
        try:
            made.stack = int(head.get("stackSize", "5000"))
        except ValueError:
            made.stack = 0
        if made.stack <= 0:
            self._say(made.project, head, f"stackSize {head.get('stackSize')!r}; a whole number of bytes above 0 is expected")
        unit = head.get("millimeterUnit", "true").lower()
        if unit not in ("true", "false", "1", "0"):
            self._say(made.project, head, f"millimeterUnit {head.get('millimeterUnit')!r} is neither true (mm) nor false (inch)")
        made.millimetres = unit not in ("false", "0")
        return True

    def _uses(self, made: Application, root: Element) -> None:
        for each in self.missing:  # what they name is known, their application is not
            for key, lost in (("alias", made.libraries), ("name", made.types)):
                if name := each.get(key):
                    lost[name] = Use(name, "", each.line)
                    made.lost_libraries.add(name)
        for group, tag, key, found in (("Libraries", "Library", "alias", made.libraries), ("Types", "Type", "name", made.types)):
            for each in (one for part in root.all(group) for one in part.all(tag)):
                name, path = each.get(key), each.get("path")
                if not name.replace("_", "a").isalnum() or (tag == "Type" and name in BUILT_IN):
                    self._say(made.project, each, _no_name(each, key))
                elif name in found:
                    self._say(made.project, each, f"'{name}' is declared twice")
                else:
                    found[name] = Use(
                        name, path, each.line, each.get("autoload").lower() == "true", each.get("password") or None, each.column
                    )

    def _file(self, made: Application, listed: Element) -> str | None:
        path = listed.get("file")
        if not path:
            self._say(made.project, listed, f"<{listed.tag}> without the attribute file, which names a file of the application")
            return None
        try:
            found = resolve(path if "://" in path else f"./{path}", made.path)
        except PathFault as fault:
            self._say(made.project, listed, str(fault))
            return None
        if self.disk.read(found) is None:
            self._say(made.project, listed, f"the file {path} is missing")
            return None
        return found

    # ---- data ------------------------------------------------------------------------------------------------------------
    def _data(self, made: Application, path: str) -> None:
        root = self._root(path, "Database", "Data/2")
        if root is None:
            _lose(made, "Database")
        made.lost |= {each.get("name") for each in self.missing}
        for each in (one for group in (root.all("Datas") if root else ()) for one in group.all("Data")):
            declared = self.declaration(path, each)
            if declared is None:
                made.lost.add(each.get("name"))
                continue
            if declared.name in made.data:
                self._say(path, each, f"'{declared.name}' is declared twice")
            else:
                made.data[declared.name] = declared

    def declaration(self, path: str, each: Element) -> Declaration | None:
        """A Data, Field or Local element."""
        name, type_name = each.get("name"), each.get("type")
        if not is_name(name):
            self._say(path, each, _no_name(each, "name"))
            return None
        kind = each.get("xsi:type", "array")
        declared = Declaration(
            name, type_name, public=each.get("access").lower() == "public", file=path, line=each.line, column=each.column
        )
        declared.type_name, declared.family = family_of(type_name)
        if kind == "collection":
            declared.dims, declared.sizes = 0, ()
        elif kind not in ("array", "element"):
            self._say(path, each, f"'{name}' : the container {kind!r} is unknown; there are array and collection")
            return None
        else:
            sizes = self._numbers(each.get("size", "1"))
            total = 1
            for size in sizes or ():
                total *= size
            if not sizes or len(sizes) > 3 or min(sizes) < 1 or total > MOST_IN_FILES:
                self._say(path, each, f"'{name}' : size {each.get('size')!r}; 1 to 3 sizes from 1, {MOST_IN_FILES} values at most")
                return None
            if total > MOST_VALUES:
                self.faults.warning("val3-size", declared.place, f"'{name}' : {total} values; a program makes {MOST_VALUES} at most")
            declared.dims, declared.sizes = len(sizes), sizes
        found = dict[str, Initial]()
        for value in (self._value(path, declared, one) for one in each.all("Value")):
            if not self._key_fits(path, declared, value):
                continue
            if value.key in found:
                self._say(path, value, f"'{name}' : there are two values with the key {value.key!r}")
            else:
                found[value.key] = value
        declared.values = [*found.values()]
        return declared

    def _value(self, path: str, declared: Declaration, each: Element) -> Initial:
        fields = {}
        for one in each.all("Field"):
            if (found := self.declaration(path, one)) is not None:
                fields[found.name] = found
        given = {**each.attributes}
        for name in ("key", "value", "fatherId"):
            if code := given.pop(f"{name}Hex", ""):
                try:
                    given[name] = bytes.fromhex(code).decode()
                except ValueError:
                    self._say(path, each, f"{name}Hex {code[:40]!r}: the bytes of a UTF-8 text are expected")
        return Initial(given.get("key", "0"), given, fields, each.line, each.column)

    def _key_fits(self, path: str, declared: Declaration, value: Initial) -> bool:
        key = value.key
        if declared.dims == 0:
            key = value.attributes.get("key", "")
            good = key != ""
        else:
            numbers = self._numbers(key)
            value.key = ",".join(map(str, numbers))
            good = len(numbers) == declared.dims and all(n < size for n, size in zip(numbers, declared.sizes, strict=True))
        if not good:
            self._say(path, value, f"'{declared.name}' : there is no value with the key {key!r}")
        return good

    @staticmethod
    def _numbers(text: str) -> tuple[int, ...]:
        """Sizes and keys of arrays: files of real controllers have sizes "3 3" and keys "0,0" (AX-1758)."""
        parts = [one for part in text.split(",") for one in part.split() or [""]]
        return tuple(int(part) for part in parts) if all(p.isascii() and p.isdecimal() and len(p) < 9 for p in parts) else ()

    # ---- programs --------------------------------------------------------------------------------------------------------
    def _programs(self, made: Application, path: str) -> None:
        root = self._root(path, "Programs", "Program/2")
        if root is None:
            _lose(made, "Programs")
        for each in root.all("Program") if root else ():
            program = self._program(path, each)
            if program is None:
                _lose(made, "Programs")
                continue
            if program.name in made.programs:
                self._say(path, each, f"the program '{program.name}' is declared twice")
            else:
                made.programs[program.name] = program

    def _program(self, path: str, each: Element) -> ProgramText | None:
        name = each.get("name")
        if not is_program_name(name):
            self._say(path, each, _no_name(each, "name"))
            return None
        code = each.first("Code")
        if code is None:
            self._say(path, each, f"the program '{name}' has no <Code>")
        text = code.text if code is not None else ""
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        while lines and not lines[0].strip():
            del lines[0]
        given = [self._parameter(path, one) for group in each.all("Parameters") for one in group.all("Parameter")]
        parameters = [one for one in given if one is not None]
        own = [self.declaration(path, one) for group in each.all("Locals") for one in group.all("Local")]
        found = [one for one in own if one is not None]
        named = {one.get("name") for tag in ("Parameters", "Locals") for group in each.all(tag) for one in group.children}
        if name in ("start", "stop") and given:
            self._say(path, each, f"'{name}' : the program cannot have parameters")  # L584, L594
        known = set[str]()
        places: list[Parameter | Declaration] = [*parameters, *found]
        for one in places:
            if one.name in known:
                self._say(path, one, f"'{one.name}' is declared twice")
            known.add(one.name)
        made = ProgramText(name, path, each.get("access").lower() == "public", parameters, found, lines, each.line)
        made.lost = named - known
        return made

    def _parameter(self, path: str, each: Element) -> Parameter | None:
        name = each.get("name")
        if not is_name(name):
            self._say(path, each, _no_name(each, "name"))
            return None
        use = each.get("use", "value").lower()
        reference = use == "reference"
        kind = each.get("xsi:type", "array" if reference else "element")  # without xsi:type: an array, by value its element
        dims = self._numbers(each.get("dimensions", "1"))
        if use not in ("value", "reference"):
            self._say(path, each, f"'{name}' : use {each.get('use')!r}; there are value and reference")
        if kind not in ("element", "array", "collection"):
            self._say(path, each, f"'{name}' : the container {kind!r} is unknown; there are element, array and collection")
        elif kind == "array" and (len(dims) != 1 or not 1 <= dims[0] <= 3):
            self._say(path, each, f"'{name}' : dimensions {each.get('dimensions')!r}; 1, 2 or 3 are expected")
        made = Parameter(name, family_of(each.get("type"))[0], reference, kind != "element", dims[0] if dims else 1, each.line, each.column)
        if kind == "collection":
            made.dims = 0
        if made.whole and not reference:
            self._say(path, each, f"'{name}' : an array or a collection is passed by reference, never by value")
        return made

    # ---- common ----------------------------------------------------------------------------------------------------------
    def _root(self, path: str, tag: str, space: str) -> Element | None:
        data = self.disk.read(path)
        if data is None:
            self.faults.error("val3-file", Position(path, 1), f"the file {path} is missing")
            return None
        if len(data) > LONGEST_FILE:
            self.faults.error("val3-file", Position(path, 1), f"the file has {len(data)} bytes, {LONGEST_FILE} at most are read")
            return None
        try:
            root = parse_xml(data)
        except XmlFault as fault:
            self._say(path, fault, fault.text)
            return None
        for line, doubt in root.doubts:
            self.faults.warning("val3-encoding", Position(path, line), doubt)
        named = root.get("xmlns", ROOT + space)
        if named.endswith("NameSpace"):  # ProjectNameSpace, DataNameSpace, ProgramNameSpace of s6
            written = next((each.get("version") for each in root.children if each.get("version")), "s6")
            self._say(path, root, f"the file was written by {written}; s7 and s8 are read, s6 and older are not")
            return None
        if root.tag != tag or not named.startswith(ROOT + space.split("/", maxsplit=1)[0]):
            self._say(path, root, f"<{tag}> of {ROOT}{space} expected, <{root.tag}> of {named} found")
            return None
        self.missing, said = [], set[str]()
        for each, text, declares in unread(root):
            if declares:
                self.missing.append(each)
                if text not in said:  # the first of them
                    self._say(path, each, text)
                said.add(text)
            else:
                self.faults.warning("val3-unread", Position(path, each.line, each.column), text)
        return root

    def _say(self, path: str, place: Place, text: str) -> None:
        self.faults.error("val3-file", Position(path, place.line, place.column), text)


def _no_name(each: Element, key: str) -> str:
    return f"'{each.get(key)}' : invalid name" if each.get(key) else f"<{each.tag}> without the attribute {key}"


def _lose(made: Application, kind: str) -> None:
    """Note an unreadable file: programs that use its content are not at fault."""
    if kind == "Database":
        made.lost_data = True
    else:
        made.lost_programs = True


def family_of(type_name: str) -> tuple[str, str]:
    """jointRx -> joint, rx; other types as they are."""
    for plain in ("joint", "point", "config"):
        rest = type_name[len(plain) :].lower()
        if type_name.startswith(plain) and rest in ("rx", "rs", "tx", "ts"):
            return plain, {"tx": "rx", "ts": "rs"}.get(rest, rest)
    return type_name, ""
