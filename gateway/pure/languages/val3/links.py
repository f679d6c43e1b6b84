"""System inputs, outputs and channels that the data of applications are linked to, as defined by their files."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from gateway.pure.languages.val3.model import Application, Declaration

GRIPPER = "valve1"  # output of a tool that has none of its own (L4923)
OUTPUTS = ("%q", "valve", "fout", "bout", "usrout", "vreg")
INPUTS = ("%i", "fin", "bin", "usrin")
NAMED_OUTPUT = re.compile(r"[da]o(?![a-z])|[DA]O", re.ASCII)  # doLamp, do_lamp, DO1, not door
WRITTEN = re.compile(r"(?:^\s*|\b(?:dio|aio)Set\s*\(\s*)((?:\w+:)?\w+)\s*(?:\[[^\]]*\]\s*)?(?:=(?!=)|,)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Link:
    """variable: the linked variable, for its name."""

    path: str
    output: bool
    analog: bool
    variable: str


def links_of_files(applications: Iterable[Application]) -> tuple[list[Link], list[str]]:
    """Inputs and outputs; links of sio."""
    found, channels = [], []
    applications = list(applications)
    written = [(app, name) for app in applications for name in _written(app)]
    abroad = {name.rpartition(":")[2] for _, name in written if ":" in name}  # of libraries
    for app in applications:
        named = abroad | {name for own, name in written if own is app}
        for declared in app.data.values():
            for inner in declarations(declared):
                for value in inner.values:
                    link = value.attributes.get("link", "")
                    if inner.type_name in ("dio", "aio") and link:
                        found.append(Link(link, is_output(link, inner.name, inner.name in named), inner.type_name == "aio", inner.name))
                    elif inner.type_name == "sio" and link:
                        channels.append(link)
                if inner.type_name == "tool":
                    grippers = [value.attributes.get("ioLink") or GRIPPER for value in inner.values]
                    found += [Link(each, output=True, analog=False, variable=inner.name) for each in grippers or [GRIPPER]]
    return found, list(dict.fromkeys(channels))


def declarations(declared: Declaration) -> Iterator[Declaration]:
    """It and the fields of its values."""
    yield declared
    for value in declared.values:
        for inner in value.fields.values():
            yield from declarations(inner)


def _written(app: Application) -> Iterator[str]:
    """Names to which programs assign something, with the library they are of."""
    for program in app.programs.values():
        for line in program.lines:
            yield from WRITTEN.findall(line)


def is_output(link: str, variable: str, written: bool = False) -> bool:
    """By its address (%Q), its name (valve1, fOut0), else by the variable (doX, aoX), or because a program writes it."""
    last = link.replace("/", "\\").rpartition("\\")[2].lower()
    if last.startswith(OUTPUTS) or "out" in last:
        return True
    if last.startswith(INPUTS):
        return False
    return written or NAMED_OUTPUT.match(variable) is not None
