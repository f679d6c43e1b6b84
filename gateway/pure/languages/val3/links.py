"""System inputs, outputs and channels that the data of applications are linked to, as their files say."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from gateway.pure.languages.val3.model import Application, Declaration

OUTPUTS = ("%q", "valve", "fout", "bout", "usrout", "vreg")


@dataclass(frozen=True, slots=True)
class Link:
    """variable: what is linked to it, for its name."""

    path: str
    output: bool
    analog: bool
    variable: str


def links_of_files(applications: Iterable[Application]) -> tuple[list[Link], list[str]]:
    """Inputs and outputs; links of sio."""
    found, channels = [], []
    for app in applications:
        for declared in app.data.values():
            for inner in declarations(declared):
                for value in inner.values:
                    link = value.attributes.get("link", "")
                    if inner.type_name in ("dio", "aio") and link:
                        found.append(Link(link, is_output(link, inner.name), inner.type_name == "aio", inner.name))
                    elif inner.type_name == "sio" and link:
                        channels.append(link)
                    elif inner.type_name == "tool" and value.attributes.get("ioLink"):
                        found.append(Link(value.attributes["ioLink"], output=True, analog=False, variable=inner.name))
    return found, list(dict.fromkeys(channels))


def declarations(declared: Declaration) -> Iterator[Declaration]:
    """It and the fields of its values."""
    yield declared
    for value in declared.values:
        for inner in value.fields.values():
            yield from declarations(inner)


def is_output(link: str, variable: str) -> bool:
    """By its address (%Q), its name (valve1, fOut0), else by the variable (doX, aoX)."""
    last = link.replace("/", "\\").rpartition("\\")[2].lower()
    if last.startswith(OUTPUTS) or "out" in last:
        return True
    if last.startswith(("%i", "fin", "bin", "usrin")):
        return False
    return variable[:2].lower() in ("do", "ao")
