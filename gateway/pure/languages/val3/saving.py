"""Writes an application back as files that load again equal: what libSave leaves on the disk."""

import math
import re
from collections.abc import Iterator, Mapping
from xml.sax.saxutils import quoteattr

from gateway.pure.languages.val3.files import ROOT
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.model import Declaration, Parameter, ProgramText, Type, Use, UserType
from gateway.pure.languages.val3.references import written
from gateway.pure.languages.val3.values import (
    Container,
    FrameV,
    Grid,
    JointV,
    LinkV,
    PointV,
    Structure,
    ToolV,
    UserV,
)

NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
NAMES = {"tvel": "tmax", "rvel": "rmax"}
LARGEST = math.nextafter(math.inf, 0.0)


def save(own: Instance, folder: str, name: str) -> Iterator[tuple[str, bytes]]:
    """Path and content of each file."""
    start = f"{folder}/" if folder else ""
    app = own.loaded.app
    yield f"{start}{name}.pjx", _project(own, name).encode()
    parts = "".join(_data(own, declared, own.data[declared.name], "Data", "    ") for declared in app.data.values())
    body = f'{HEAD}<Database {XSI} xmlns="{ROOT}Data/2">\n  <Datas>\n{parts}  </Datas>\n</Database>\n'
    yield f"{start}{name}.dtx", body.encode()
    for program in app.programs.values():
        yield f"{start}{program.name}.pgx", _program(program).encode()


def _attributes(given: Mapping[str, object]) -> str:
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in given.items())


def _project(own: Instance, name: str) -> str:
    app = own.loaded.app
    head = _attributes({"version": app.version, "stackSize": app.stack, "millimeterUnit": str(app.millimetres).lower()})
    programs = "".join(f"    <Program{_attributes({'file': f'{each}.pgx'})} />\n" for each in app.programs)
    libraries = "".join(f"    <Library{_attributes(_library(use))} />\n" for use in app.libraries.values())
    types = "".join(f"    <Type{_attributes({'name': use.name, 'path': use.path})} />\n" for use in app.types.values())
    return (
        f'{HEAD}<Project xmlns="{ROOT}Project/3">\n  <Parameters{head} />\n  <Programs>\n{programs}  </Programs>\n  <Database>\n'
        f"    <Data{_attributes({'file': f'{name}.dtx'})} />\n  </Database>\n  <Libraries>\n{libraries}  </Libraries>\n"
        f"  <Types>\n{types}  </Types>\n</Project>\n"
    )


def _library(use: Use) -> dict[str, object]:
    made: dict[str, object] = {"alias": use.name, "path": use.path}
    if use.autoload:
        made["autoload"] = "true"
    return made if use.password is None else {**made, "password": use.password}


def _data(own: Instance, declared: Declaration, container: Container, tag: str, indent: str) -> str:
    head: dict[str, object] = {"name": declared.name}
    if tag == "Data":
        head["access"] = "public" if declared.public else "private"
    head["xsi:type"] = "collection" if declared.dims == 0 else "array"
    head["type"] = declared.type_name + declared.family.capitalize()
    values: list[tuple[str, object]]
    if isinstance(container, dict):
        values = list(container.items())
    else:
        grid = container if isinstance(container, Grid) else Grid((len(container),), container)
        head["size"] = " ".join(map(str, grid.dims))
        values = [(_key(at, grid.dims), value) for at, value in enumerate(grid.flat)]
    inner = "".join(_value(own, declared.type, key, value, indent + "  ") for key, value in values)
    return f"{indent}<{tag}{_attributes(head)}>\n{inner}{indent}</{tag}>\n"


def _key(place: int, dims: tuple[int, ...]) -> str:
    indices = []
    for size in reversed(dims):
        place, index = divmod(place, size)
        indices.append(str(index))
    return ",".join(reversed(indices))


def _value(own: Instance, kind: Type, key: str, value: object, indent: str) -> str:
    if isinstance(value, UserV) and isinstance(kind, UserType):
        fields = "".join(_data(own, each, getattr(value, f"u_{name}"), "Field", indent + "  ") for name, each in kind.fields.items())
        return f"{indent}<Value{_attributes(_text('key', key))}>\n{fields}{indent}</Value>\n"
    return f"{indent}<Value{_attributes({**_text('key', key), **_plain(own, value)})} />\n"


def _plain(own: Instance, value: object) -> dict[str, object]:
    match value:
        case bool():
            return {"value": str(value).lower()}
        case float():
            return {"value": _number(value)}
        case str():
            return _text("value", value)
        case LinkV():
            return {"link": value.link} if value.link else {}
        case ToolV():
            found = {**_plain(own, value.trsf), "ioOpen": _number(value.otime), "ioClose": _number(value.ctime)}
            return {**found, "ioLink": value.gripper.link or "", **_father(own, value.father)}
        case FrameV():
            return {**_plain(own, value.trsf), **_father(own, value.father)}
        case PointV():
            return {**_plain(own, value.trsf), **_plain(own, value.config), **_father(own, value.father)}
        case JointV():
            return {name: _number(getattr(value, name)) for name in value.names()}
        case Structure():
            return {NAMES.get(name, name): _shown(getattr(value, name)) for name in value.names()}
    return {}


def _text(name: str, text: str) -> dict[str, object]:
    """Return a text as an attribute; if XML lacks its characters (STX of a telegram), add its bytes (AX-1737)."""
    clean = NOT_IN_XML.sub("", text)
    return {name: text} if clean == text else {name: clean, f"{name}Hex": text.encode("utf-8", "replace").hex()}


def _shown(value: object) -> str:
    return _number(value) if isinstance(value, float) else str(value)


def _number(value: float) -> str:
    """As a file has it: no infinity, which no file may hold."""
    if math.isnan(value):
        return "0.0"
    return repr(max(-LARGEST, min(value, LARGEST)))


def _father(own: Instance, father: FrameV | ToolV | None) -> dict[str, object]:
    if father is None:
        return {"fatherId": ""}
    if father.root:
        return {"fatherId": "world[0]" if isinstance(father, FrameV) else "flange[0]"}
    if father.lost is not None:
        return _text("fatherId", father.lost[1])
    abroad = ((f"{alias}:", library.data) for alias, library in own.libraries.items() if library is not None)
    for prefix, data in (("", own.data), *abroad):
        for name, container in data.items():
            if found := written(name, container, father):
                return _text("fatherId", prefix + found)
    return {}


def _program(program: ProgramText) -> str:
    parameters = "".join(f"      <Parameter{_attributes(_parameter(each))} />\n" for each in program.parameters)
    found = "".join(f"      <Local{_attributes(_local(each))} />\n" for each in program.locals)
    code = "\n".join(program.lines).replace("]]>", "]]]]><![CDATA[>")
    access = "public" if program.public else "private"
    return (
        f'{HEAD}<Programs {XSI} xmlns="{ROOT}Program/2">\n  <Program{_attributes({"name": program.name, "access": access})}>\n'
        f'    <Parameters xmlns="{ROOT}Param/1">\n{parameters}    </Parameters>\n    <Locals>\n{found}    </Locals>\n'
        f"    <Code><![CDATA[{code}]]></Code>\n  </Program>\n</Programs>\n"
    )


def _parameter(each: Parameter) -> dict[str, object]:
    kind = "element" if not each.whole else "collection" if each.dims == 0 else "array"
    made: dict[str, object] = {"name": each.name, "type": each.type_name, "xsi:type": kind}
    if each.reference:
        made["use"] = "reference"
    if each.dims > 1:
        made["dimensions"] = each.dims
    return made


def _local(each: Declaration) -> dict[str, object]:
    made: dict[str, object] = {"name": each.name, "type": each.type_name + each.family.capitalize()}
    if each.dims == 0:
        return {**made, "xsi:type": "collection"}
    return {**made, "xsi:type": "array", "size": " ".join(map(str, each.sizes))}
