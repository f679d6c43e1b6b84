"""User pages as data: bindings, displayed values, effects of events and entries.  Source: VAL 3 reference 4.1 and 14.2.

Nothing is drawn here.  A binding is a variable (container and place) and an attribute of an object of a page.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.strings import finite
from gateway.pure.languages.val3.values import AioV, DioV, cut, places
from gateway.pure.languages.val3.virtual_io import VirtualIo

DIRECTIONS = ("r", "w", "rw", "r1", "rw1")  # the last one: doubt D08
FORBIDDEN = frozenset(
    "id hidden for name style.height style.left style.margin style.padding style.width style.top".split()
)  # of all objects (L6744-6828); on... and data-... besides
WRITABLE = ("value",)  # L6982
EITHER = ("selectedIndex", "value")  # L6983-6987: only one of them
LIST = "options"  # one value for each element of the array
EVENTS = ("mouseup", "mousedown", "click")
MOST = 1000  # bindings of an application
UNREADABLE = (Rte, RuntimeFault, LookupError)  # no link, a board in fault, an element or key that was deleted

Where = tuple[object, object]  # container and place


@dataclass(slots=True)
class Binding:
    """variable <-> attribute."""

    page: str
    id: str
    attribute: str
    where: Where
    size: int
    direction: str

    @property
    def reads(self) -> bool:
        """The page follows the variable."""
        return self.direction in ("r", "rw")

    @property
    def writes(self) -> bool:
        """An entry on the page sets the variable."""
        return self.direction in ("w", "rw", "rw1")


@dataclass(slots=True)
class Reaction:
    """An event sets a variable; value None: it is toggled."""

    page: str
    id: str
    event: str
    where: Where
    value: object


class Prompt(NamedTuple):
    """A question that waits for the operator.  kind: alert, confirm or prompt."""

    text: str
    kind: str


@dataclass(slots=True)
class PageBoard:
    """All pages of the applications."""

    io: VirtualIo
    current: str = ""
    folder: str = ""  # on the disk, of the application that shows it
    bindings: list[Binding] = field(default_factory=list)
    reactions: list[Reaction] = field(default_factory=list)
    fixed: dict[tuple[str, str, str], list[str]] = field(default_factory=dict)
    objects: dict[tuple[str, str], dict[str, str] | None] = field(default_factory=dict)  # folder and page -> types by id
    judged: set[tuple[str, str, str, str]] = field(default_factory=set)  # attributes the catalogue was asked for

    # ---- instructions ------------------------------------------------------------------------------------------------------
    def load(self, page: str, folder: str = "") -> None:
        """userPage: read the values that are read only once."""
        self.current, self.folder = page, folder
        for binding in self.bindings:
            if binding.page == page and binding.direction in ("r1", "rw1"):
                self._once(binding)

    def bind(self, page: str, name: str, attribute: str, where: Where, size: float, direction: str, refresh: float = 1.0) -> str:
        """userPageBind; a warning for the log, "" for none.  70: a forbidden attribute, direction, size or refresh."""
        if direction not in DIRECTIONS:
            raise Rte(70, f"direction {direction!r}: {', '.join(DIRECTIONS)}")
        self._judge(attribute)
        if "w" in direction and attribute not in WRITABLE:
            raise Rte(70, f"{attribute} cannot be bound with {direction!r}: the page writes {', '.join(WRITABLE)} only")
        count = int(size)
        container, place = where
        room = len(container) - place if isinstance(container, list) and isinstance(place, int) else 1
        if count != size or not 1 <= count <= room or refresh < 1:
            raise Rte(70, f"nSize {size:g} of {room}, nRefresh {refresh:g}")
        if len(self.bindings) >= MOST:
            raise Rte(40, f"{MOST} bindings")
        made = Binding(page, name, attribute, where, count, direction)
        others = [each for each in self.bindings if (each.page, each.id) == (page, name)]
        self.bindings = [each for each in self.bindings if not _same(each, made)] + [made]
        if direction in ("r1", "rw1"):
            self._once(made)
        if attribute in EITHER and any(each.attribute in EITHER and each.attribute != attribute for each in others):
            return f"page {page}, {name}: only one of {' and '.join(EITHER)} can be bound"
        return ""

    def unbind(self, page: str, name: str, attribute: str) -> bool:
        """userPageUnbind: whether there was one."""
        kept = [each for each in self.bindings if (each.page, each.id, each.attribute) != (page, name, attribute)]
        found, self.bindings = len(kept) < len(self.bindings), kept
        return found

    def react(self, page: str, name: str, event: str, where: Where, value: object) -> None:
        """userPageBindClick and its like; an event may have several."""
        if len(self.reactions) >= MOST:
            raise Rte(40, f"{MOST} bindings")
        self.reactions.append(Reaction(page, name, event, where, value))

    def ignore(self, page: str, name: str, event: str, where: Where) -> bool:
        """userPageUnbindClick and its like: whether there was one."""
        wanted = (page, name, event)
        kept = [
            each
            for each in self.reactions
            if (each.page, each.id, each.event) != wanted or each.where[0] is not where[0] or each.where[1] != where[1]
        ]
        found, self.reactions = len(kept) < len(self.reactions), kept
        return found

    def put(self, page: str, name: str, attribute: str, value: object) -> None:
        """userPageSet: once."""
        self._judge(attribute)
        text = _text(value)
        self.fixed[page, name, attribute] = text.split(",") if attribute == LIST else [text]

    def replaced(self, old: Mapping[str, object], new: Mapping[str, object]) -> None:
        """Rebind objects to data that replaced others of the same name and type."""
        names = {id(container): name for name, container in old.items()}
        bound: list[Binding | Reaction] = [*self.bindings, *self.reactions]
        for each in bound:
            name = names.get(id(each.where[0]), "")
            if name in new:
                each.where = (new[name], each.where[1])

    # ---- the operator --------------------------------------------------------------------------------------------------------
    def happen(self, page: str, name: str, event: str) -> str:
        """A click, or a button pressed or released; which variables could not be set and why, "" for none."""
        faults = []
        for each in [each for each in self.reactions if (each.page, each.id, each.event) == (page, name, event)]:
            try:
                self._write(each.where, (not self._value(each.where, 0)) if each.value is None else each.value)
            except UNREADABLE as fault:
                faults.append(f"page {page}, {name}: {event} has no effect: {_why(fault)}")
        return "; ".join(faults)

    def enter(self, page: str, name: str, attribute: str, text: str) -> bool:
        """Process an entry; False: the object is not writable, or the text is not a valid value."""
        found = [each for each in self.bindings if (each.page, each.id, each.attribute) == (page, name, attribute) and each.writes]
        for each in found:
            try:
                value = _value_of(self._value(each.where, 0), text)
                if value is None:
                    return False
                self._write(each.where, value)
            except UNREADABLE:
                return False
        if found:
            self.fixed[page, name, attribute] = [text]
        return bool(found)

    # ---- display --------------------------------------------------------------------------------------------------------------
    def shown(self) -> dict[str, dict[str, dict[str, str]]]:
        """Page -> object -> attribute -> text."""
        found: dict[str, dict[str, dict[str, str]]] = {}
        for (page, name, attribute), texts in self._now().items():
            found.setdefault(page, {}).setdefault(name, {})[attribute] = ",".join(texts)
        return found

    def rows(self, page: str) -> list[list[str]]:
        """Object, attribute and text of one page; a row for each option of a list."""
        return [
            [name, attribute, text]
            for (of, name, attribute), texts in self._now().items()
            if of == page
            for text in (texts if attribute == LIST else [",".join(texts)])
        ]

    def _now(self) -> dict[tuple[str, str, str], list[str]]:
        return self.fixed | {(each.page, each.id, each.attribute): self._texts(each) for each in self.bindings if each.reads}

    def _once(self, binding: Binding) -> None:
        self.fixed[binding.page, binding.id, binding.attribute] = self._texts(binding)

    def _texts(self, binding: Binding) -> list[str]:
        return [self._readable(binding.where, at) for at in range(binding.size)]

    def _readable(self, where: Where, at: int) -> str:
        """ "" for what cannot be read now."""
        try:
            return _text(self._value(where, at))
        except UNREADABLE:
            return ""

    def _value(self, where: Where, at: int) -> object:
        container, place = where
        if isinstance(place, int) and isinstance(container, list):
            value: object = container[place + at] if place + at < len(container) else ""
        else:
            value = places(container)[place]
        if isinstance(value, DioV):
            return self.io.usable(value.link).value != 0
        return self.io.usable(value.link).value if isinstance(value, AioV) else value

    def _write(self, where: Where, value: object) -> None:
        container, place = where
        old = places(container)[place]
        if isinstance(old, DioV | AioV):
            self.io.write(old.link, float(value) if isinstance(value, int | float) else 0.0)
        else:
            places(container)[place] = value

    @staticmethod
    def _judge(attribute: str) -> None:
        if attribute in FORBIDDEN or attribute.startswith(("on", "data-")) or not attribute:
            raise Rte(70, f"the attribute {attribute!r} must not be used")


def _same(one: Binding, other: Binding) -> bool:
    return (one.page, one.id, one.attribute, one.reads, one.writes) == (
        other.page,
        other.id,
        other.attribute,
        other.reads,
        other.writes,
    )


def _why(fault: Exception) -> str:
    return "the element does not exist any more" if isinstance(fault, LookupError) else str(fault)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.14g}" if isinstance(value, float) else str(value)


def _value_of(old: object, text: str) -> object:
    """The text as a value of the variable's type; None: it is none."""
    if isinstance(old, bool):
        return {"true": True, "1": True, "false": False, "0": False}.get(text.lower())
    if isinstance(old, float):
        return finite(text)
    return cut(text)
