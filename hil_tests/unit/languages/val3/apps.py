"""Writes small applications as the files a controller would have, loads and runs them."""

import pathlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from gateway.files.robots import load_robot
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.virtual import Run, declare_links
from gateway.pure.languages.val3.virtual_events import event_of

HEAD = '\ufeff<?xml version="1.0" encoding="utf-8"?>\n<!-- written by hand -->\n'
SPACE = "http://www.staubli.com/robotics/VAL3/"
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
VECTORS = pathlib.Path(__file__).resolve().parents[3] / "vectors" / "val3"
ROBOT = load_robot("tx60-like")


def datum(name: str, kind: str, size: str = "1", values: str = "", access: str = "public") -> str:
    """A Data element; size "" is a collection."""
    container = f'xsi:type="array" type="{kind}" size="{size}"' if size else f'xsi:type="collection" type="{kind}"'
    return f'<Data name="{name}" access="{access}" {container}>{values}</Data>\n'


def value(key: str = "0", **attributes: object) -> str:
    """A Value element."""
    given = "".join(f' {name}="{each}"' for name, each in attributes.items())
    return f'<Value key="{key}"{given} />'


def parameter(text: str) -> str:
    """num& nX[] -> a Parameter element."""
    kind, name = text.split()
    reference = kind.endswith("&")
    kind = kind.rstrip("&")
    container, dims = "element", 1
    if name.endswith("]"):
        name, _, inside = name.partition("[")
        container = "collection" if '"' in inside else "array"
        dims = inside.count(",") + 1
    use = ' use="reference"' if reference else ""
    return f'<Parameter name="{name}" type="{kind}" xsi:type="{container}"{use} dimensions="{dims}" />'


def local(text: str) -> str:
    """num l_n[5] -> a Local element."""
    kind, name = text.split()
    name, _, size = name.partition("[")
    return f'<Local name="{name}" type="{kind}" xsi:type="array" size="{size.rstrip("]") or 1}" />'


@dataclass
class App:
    """name, data and programs: {"main(num& x)": (["num l_i"], "code")} or code alone."""

    name: str = "demo"
    data: str = ""
    programs: Mapping[str, str | tuple[Iterable[str], str]] = field(default_factory=dict)
    libraries: str = ""
    types: str = ""
    millimetres: bool = True
    stack: int = 5000
    access: str = "public"

    def files(self) -> dict[str, bytes]:
        """Path -> content."""
        made = {}
        listed = {**self.programs}
        for needed in ("start", "stop"):
            if not any(each.split("(")[0] == needed for each in listed):
                listed[needed] = ""
        names = [each.split("(")[0] for each in listed]
        programs = "".join(f'<Program file="{name}.pgx" />' for name in names)
        made[f"{self.name}/{self.name}.pjx"] = (
            f'{HEAD}<Project xmlns="{SPACE}Project/3"><Parameters version="s7.9.1" stackSize="{self.stack}" '
            f'millimeterUnit="{str(self.millimetres).lower()}" /><Programs>{programs}</Programs>'
            f'<Database><Data file="{self.name}.dtx" /></Database><Libraries>{self.libraries}</Libraries>'
            f"<Types>{self.types}</Types></Project>"
        )
        made[f"{self.name}/{self.name}.dtx"] = f'{HEAD}<Database {XSI} xmlns="{SPACE}Data/2"><Datas>\n{self.data}</Datas></Database>'
        for head, body in listed.items():
            name, _, inside = head.partition("(")
            locals_, code = ((), body) if isinstance(body, str) else body
            given = "".join(parameter(each.strip()) for each in _split(inside.rstrip(")")))
            made[f"{self.name}/{name}.pgx"] = (
                f'{HEAD}<Programs {XSI} xmlns="{SPACE}Program/2"><Program name="{name}" access="{self.access}">'
                f'<Parameters xmlns="{SPACE}Param/1">{given}</Parameters><Locals>{"".join(map(local, locals_))}</Locals>'
                f"<Code><![CDATA[begin\n{code.strip(chr(10))}\nend]]></Code></Program></Programs>"
            )
        return {path: text.encode() for path, text in made.items()}


def _split(text: str) -> list[str]:
    found, depth, start = [], 0, 0
    for at, letter in enumerate(text):
        depth += {"[": 1, "]": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            found.append(text[start:at])
            start = at + 1
    return [*found, text[start:]] if text.strip() else []


def disk(*apps: App) -> Disk:
    """All of them on one disk."""
    return Disk({path: data for app in apps for path, data in app.files().items()})


def machine(*apps: App, arm: bool = False, line_ns: int = 1_000) -> Machine:
    """A controller with these applications on its disk."""
    return Machine(disk(*apps), Moves(ROBOT, (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)) if arm else None, line_ns)


def run(
    *apps: App,
    at: Iterable[tuple[float, str]] = (),
    until: float = 10.0,
    arm: bool = False,
    on: Machine | None = None,
    line_ns: int = 1_000,
) -> dict[str, object]:
    """Runs the first one to its end."""
    made = on or machine(*apps, arm=arm, line_ns=line_ns)
    own = made.instance(apps[0].name, apps[0].name, "")
    assert own is not None, made.log
    declare_links(made, own.data.values())
    going = Run(made, own, round(until * 1e9), [event_of(str(seconds), what) for seconds, what in at])
    going.go()
    return going.result()


def globals_of(code: str, data: str, *libraries: App, arm: bool = False, until: float = 10.0, **programs: str) -> dict[str, object]:
    """Data after start() has run this code; a task left in error fails the test."""
    result = run(App(data=data, programs={"start": code, **programs}), *libraries, arm=arm, until=until)
    tasks = result["tasks"]
    assert isinstance(tasks, dict)
    assert not [each for each in tasks.values() if each["status"] > 1], result["log"]
    found = result["globals"]
    assert isinstance(found, dict)
    return found


def error_of(code: str, data: str = "", arm: bool = False, **programs: str) -> int:
    """The code start() stops with; 0: it ran to its end."""
    result = run(App(data=data, programs={"start": code, **programs}), arm=arm)
    tasks = result["tasks"]
    assert isinstance(tasks, dict)
    status = tasks["demo~"]["status"] if "demo~" in tasks else 0
    assert isinstance(status, int)
    return status


def faults_of(code: str, data: str = "", locals_: Iterable[str] = (), **programs: str) -> list[tuple[int, str]]:
    """Line and text of each compile error of start()."""
    found = Loader(disk(App(data=data, programs={"start": (locals_, code), **programs}))).load("demo", "demo")
    assert found is not None
    return [(fault.position.line, fault.text) for fault in found.faults]


def check(app: App, *others: App) -> Faults:
    """All faults of an application."""
    found = Loader(disk(app, *others)).load(app.name, app.name)
    assert found is not None
    return found.faults
