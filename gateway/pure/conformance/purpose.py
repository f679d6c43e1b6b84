"""A test purpose as data, in the manner of ETSI, and how purposes are collected and selected."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")  # the tester of the suite
GROUPS = {
    "BV": "valid behaviour",
    "BI": "invalid behaviour",
    "BO": "inopportune behaviour",
    "TI": "timers",
    "CA": "capabilities",
    "RC": "recovery",
    "ST": "stress",
}


@dataclass(frozen=True, slots=True)
class Purpose(Generic[T]):
    """One question to the device.

    condition: keys of the PICS that must be true, else N/A before anything is sent.  preamble: purposes of the same suite from whose
    behaviour this one starts; where one of them failed this one is INCONC and names it.  body: ends quietly (PASS) or by an Ended.
    postamble: whether the suite's own postamble (the device is idle and works) follows.  early: runs before the shuffled ones, in the
    order of the suite: of several cases that meet the same fault the same one has the FAIL in each run.
    """

    id: str
    role: str
    summary: str
    summary_de: str
    clause: str
    body: Callable[[T], None]
    requirements: tuple[str, ...] = ()
    cross_reference: str = ""
    condition: tuple[str, ...] = ()
    preamble: tuple[str, ...] = ()
    postamble: bool = True
    limits: str = ""
    early: bool = False

    @property
    def group(self) -> str:
        """BV BI BO TI CA RC ST: the part before the number."""
        return self.id.split("_")[-2]


@dataclass(frozen=True, slots=True)
class Particulars:
    """Fields that few cases have: a reference in addition to the clause, limits in words, an own end instead of the suite's postamble, an
    early turn.
    """

    cross: str = ""
    limits: str = ""
    postamble: bool = True
    early: bool = False


USUAL = Particulars()


class Purposes(Generic[T]):
    """Collects the purposes of a suite in the order in which they are in the source."""

    def __init__(self, prefix: str, role: str, clause: str, condition: tuple[str, ...] = (), preamble: tuple[str, ...] = ()) -> None:
        self._prefix, self._role, self._clause = prefix, role, clause
        self._condition, self._preamble = condition, preamble
        self.all: list[Purpose[T]] = []

    def case(
        self,
        name: str,
        summary: str,
        summary_de: str,
        *,
        clause: str = "",
        requirements: Sequence[str] = (),
        condition: Sequence[str] = (),
        preamble: Sequence[str] | None = None,
        beside: Particulars = USUAL,
    ) -> Callable[[Callable[[T], None]], Callable[[T], None]]:
        """Decorator: this function is the body of a purpose."""

        def keep(body: Callable[[T], None]) -> Callable[[T], None]:
            before = self._preamble if preamble is None else tuple(preamble)
            self.all.append(
                Purpose(
                    f"{self._prefix}_{name}",
                    self._role,
                    summary,
                    summary_de,
                    clause or self._clause,
                    body,
                    tuple(requirements),
                    beside.cross,
                    (*self._condition, *condition),
                    before,
                    beside.postamble,
                    beside.limits,
                    beside.early,
                )
            )
            return body

        return keep


def selected(purposes: Sequence[Purpose[T]], only: Sequence[str]) -> list[Purpose[T]]:
    """Those an id, a group or a glob names; all without one."""
    if not only:
        return list(purposes)
    return [one for one in purposes if any(_named(one, name) for name in only)]


def unknown(purposes: Sequence[Purpose[T]], only: Sequence[str]) -> list[str]:
    """Names that select nothing."""
    return [name for name in only if not any(_named(one, name) for one in purposes)]


def _named(one: Purpose[T], name: str) -> bool:
    """As a shell's glob, in any case: * any characters, ? one, [1-3] one of these."""
    return name.upper() in (one.id.upper(), one.group.upper()) or re.fullmatch(_pattern(name.upper()), one.id.upper()) is not None


def _pattern(glob: str) -> str:
    plain = re.escape(glob).replace(r"\*", ".*").replace(r"\?", ".")
    return re.sub(r"\\\[([\w\\-]+)\\\]", lambda found: f"[{found[1].replace(chr(92), '')}]", plain)
