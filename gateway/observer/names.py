"""Every value of a cell by every name and address it has, with where it is used: made once, searched as fast as one types."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from gateway.assembly.telegrams import named_values
from gateway.files.signal_lists import signal_list
from gateway.pure.arbitration.block_keys import block_key
from gateway.pure.arbitration.data_blocks import RC_NAMES
from gateway.pure.cell.cell import Cell, Db
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, PERMITS
from gateway.pure.image.addresses import AddressFault, DataBit, DataWord, Direction, Kind, Operand, RcBit, parse, parse_operand, pic
from gateway.pure.image.records.cell import RC_BYTES
from gateway.pure.image.signals import SignalList

AXIS_FIELDS = ("actual", "set", "lag", "speed", "torque", "enabled", "referenced", "in_position", "fault")
CELL_FIELDS = ("ready", "drives_on", "emergency_stop", "error", "life", "override", "motion")
MOST = 200  # rows of one answer
MOST_USED = 16  # places of use listed in a row, and searched by


@dataclass(frozen=True, slots=True)
class Entry:
    """One value.  `id` is the name used in a watch list: in:24, out:64, db:10:2, db:10:0.8, axis:A1.actual, cell.ready, named:order.number,
    io:button, inw:90:2 (two bytes of the RC inputs from byte 90 on), outw:64:1."""

    id: str
    group: str  # branch of the tree: RC inputs / byte 3; DB 10; axes / A1
    name: str
    addresses: tuple[str, ...]
    kind: str  # bit | word | number | text
    type: str = ""  # STEP 5 type of an entry
    unit: str = ""
    en: str = ""
    de: str = ""
    source: str = ""  # axisgate where the number is ours (AX-002)
    writer: str = ""  # who writes it
    used: tuple[str, ...] = ()

    @property
    def forcible(self) -> bool:
        return self.id.startswith("in:")

    def row(self) -> dict[str, object]:
        """For the page."""
        names = ("id", "group", "name", "addresses", "kind", "type", "unit", "en", "de", "source", "writer", "forcible")
        return {
            **{name: getattr(self, name) for name in names},
            "used": self.used[:MOST_USED],
            "used_more": max(0, len(self.used) - MOST_USED),
        }


class Names:
    """The index of one cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        signals = signal_list()
        self.signals: SignalList = signals.moved(cell.signals) if cell.signals else signals
        self._used = _uses(cell)
        self.all = [*self._cell_values(), *self._axes(), *self._blocks(), *self._named(), *self._contacts(), *self._rc()]
        self.by_id = {entry.id: entry for entry in self.all}
        self._texts = [_searchable(entry) for entry in self.all]

    def search(self, words: str, group: str = "") -> tuple[int, list[Entry]]:
        """How many fit, and the first of them; every word must occur in a name, address, text or use; exact names first."""
        wanted = [word.casefold() for word in words.split()]
        squeezed = "".join(wanted)
        found = [
            entry
            for entry, text in zip(self.all, self._texts, strict=True)
            if (not group or entry.group == group or entry.group.startswith(group + " /"))
            and (all(word in text for word in wanted) or squeezed in text)
        ]
        first = words.strip().casefold()
        if first:
            found.sort(key=lambda entry: (not _is(entry, first), not entry.name.casefold().startswith(first)))
        wide = [entry for entry in self._wide(words) if not group or entry.group == group or entry.group.startswith(group + " /")]
        found = [*wide, *(entry for entry in found if entry not in wide)]
        return len(found), found[:MOST]

    def entry(self, id_: str) -> Entry:
        """The value with this id of a watch list, also bytes and words of the image, which are in no list.  KeyError: no such value."""
        found = self.by_id.get(id_)
        if found is not None:
            return found
        match id_.split(":"):
            case ["inw" | "outw" as area, byte, size] if byte.isdecimal() and size in ("1", "2", "4") and int(byte) + int(size) <= RC_BYTES:
                return self._word(Operand(Kind.OUTPUT if area == "inw" else Kind.INPUT, int(byte), bytes=int(size)))
        raise KeyError(f"no value {id_}")

    def _wide(self, words: str) -> list[Entry]:
        """`AW 90`, `EB 8`, `QD 4`: this part of the process image, and each of its bits; []: the words name none."""
        try:
            place = parse_operand(words)
        except AddressFault:
            return []
        if not isinstance(place, Operand) or place.kind not in (Kind.INPUT, Kind.OUTPUT):
            return []
        prefix = "in" if place.kind is Kind.OUTPUT else "out"
        bits = range(8 * place.number, 8 * (place.number + place.bytes))
        return [self._word(place), *(self.by_id[f"{prefix}:{number}"] for number in bits)]

    @staticmethod
    def _word(place: Operand) -> Entry:
        """An output of the PLC is an RC input; its first byte is the high one, as in STEP 5."""
        inward = place.kind is Kind.OUTPUT
        width = {1: "B", 2: "W", 4: "D"}[place.bytes]
        addresses = tuple(f"{letter}{width} {place.number}" for letter in ("AQO" if inward else "EI"))
        title = f"RC {'inputs' if inward else 'outputs'} / byte {place.number}"
        kind = {1: "KY", 2: "KF", 4: "DH"}[place.bytes]
        return Entry(f"{'inw' if inward else 'outw'}:{place.number}:{place.bytes}", title, addresses[0], addresses, "word", kind)

    def _contacts(self) -> Iterator[Entry]:
        for io in self.cell.io:
            way = "input" if io.device.input is not None else "output"
            channel = io.device.input if io.device.input is not None else io.device.output
            place = " ".join(
                str(part) for part in (io.device.type, io.device.bus or io.device.url or io.device.chip, io.device.node) if part
            )
            used = self._used.get(f"io.{io.name}", ())
            yield Entry(
                f"io:{io.name}", "contacts", f"io.{io.name}", (io.signal, f"{place} {way} {channel}"), "bit",
                writer=place if way == "input" else "axisgate", used=tuple(used),
            )  # fmt: skip

    def tree(self) -> list[dict[str, object]]:
        """Branches with how many values each has, in their order."""
        counts: dict[str, int] = {}
        for entry in self.all:
            counts[entry.group] = counts.get(entry.group, 0) + 1
        return [{"group": group, "count": count} for group, count in counts.items()]

    def _rc(self) -> Iterator[Entry]:
        for direction, prefix, title in ((Direction.INPUT, "in", "RC inputs"), (Direction.OUTPUT, "out", "RC outputs")):
            for number in range(8 * RC_BYTES):
                yield self._bit(RcBit(direction, number), prefix, title)

    def _bit(self, place: RcBit, prefix: str, title: str) -> Entry:
        number, signal = place.number, self.signals.at(place)
        inward = place.direction is Direction.INPUT
        table = f"{number + 1:05d}" if inward else f"{10001 + number}"
        register = str((40001 if inward else 30001) + number // 16)  # AX-012: word r is bytes 2r and 2r+1
        addresses = (f"{'RCI' if inward else 'RCO'} {number}", pic(place), table, register, *(signal.also if signal else ()))
        owner = self.cell.rc_inputs.owner.get(number >> 3, "") if inward else "cycle"
        name = signal.name if signal else f"{'RC input' if inward else 'RC output'} {number}"
        used = self._used.get(f"{prefix}:{number}", ())
        return Entry(
            f"{prefix}:{number}",
            f"{title} / byte {number >> 3}",
            name,
            addresses,
            "bit",
            en=signal.en if signal else "",
            de=signal.de if signal else "",
            source=signal.source if signal else "",
            writer=owner,
            used=tuple(used),
        )

    def _blocks(self) -> Iterator[Entry]:
        for block in self.cell.db:
            yield from _entries(block, self._used)

    def _axes(self) -> Iterator[Entry]:
        for axis in self.cell.axis:
            for field in AXIS_FIELDS:
                name = f"axis.{axis.name}.{field}"
                bit = AXIS_FIELDS.index(field) > 4
                unit = {"torque": "%", "speed": f"{axis.unit}/s"}.get(field, "" if bit else axis.unit)
                drive = f"{axis.drive.type} {axis.drive.bus} {axis.drive.node or axis.drive.module}"
                used = tuple(self._used.get(name, ()))
                yield Entry(name, f"axes / {axis.name}", name, (drive,), "bit" if bit else "number", unit=unit, writer="cycle", used=used)

    def _cell_values(self) -> Iterator[Entry]:
        for field in CELL_FIELDS:
            name = f"cell.{field}"
            kind = "number" if field in ("life", "override", "motion") else "bit"
            yield Entry(
                name, "cell", name, (), kind, unit="%" if field == "override" else "", writer="cycle", used=tuple(self._used.get(name, ()))
            )

    def _named(self) -> Iterator[Entry]:
        for name in named_values(self.cell).names():
            yield Entry(f"named:{name}", "named values", name, (), "text", writer="telegrams", used=tuple(self._used.get(name, ())))


def _entries(block: Db, used: dict[str, list[str]]) -> Iterator[Entry]:
    title = f"D{'X' if block.kind == 'X' else 'B'} {block.number}" if block.kind in "DX" else f"{block.kind} {block.number}"
    key = block_key(block.kind, block.number)
    for entry in block.entries:
        place = parse(entry.at, db=block.number)
        if isinstance(place, DataBit):
            where, kind = f"{place.word}.{place.bit}", "bit"
        elif isinstance(place, DataWord):
            where, kind = f"{place.word}{'' if place.part.value == 'DW' else place.part.value}", "word"
        else:
            continue
        names = (str(place), f"DB{block.number} {entry.at}", entry.at)
        places = (f"{'PLC writes' if entry.to else 'axisgate writes'} line {block.line}", *used.get(entry.signal, ()))
        yield Entry(
            f"db:{key}:{where}", title, entry.signal, names, kind, entry.type, entry.unit, entry.comment, entry.comment,
            writer=block.line if block.writer == "plc" else "axisgate", used=tuple(dict.fromkeys(places)),
        )  # fmt: skip


def _uses(cell: Cell) -> dict[str, list[str]]:
    """Name or id -> its places in the cell."""
    used: dict[str, list[str]] = defaultdict(list)
    for block in cell.db:
        for entry in block.entries:
            place = f"DB {block.number} {entry.at} ({entry.type}), line {block.line}"
            used[entry.signal].append(place)
            if entry.signal in RC_NAMES:
                used[f"in:{getattr(AS_SHIPPED, RC_NAMES[entry.signal])}"].append(place)
    for name, handshake in cell.handshake.items():
        for what in ("start", "busy", "done", "refused"):
            used[getattr(handshake, what)].append(f"handshake.{name}.{what}")
    for server in cell.modbus:
        for octet, owner in cell.rc_inputs.owner.items():
            if owner == server.name:
                for number in range(8 * octet, 8 * octet + 8):
                    used[f"in:{number}"].append(f"modbus {server.name}: coil {number}")
    for contact in cell.io:
        used[contact.signal].append(f"io {contact.name}")
    for route in cell.route:
        used[route.from_].append(f"route {route.name} to {route.to}")
        used[route.to].append(f"route {route.name} from {route.from_}")
    _telegrams(cell, used)
    for name, _ in PERMITS:
        used[f"in:{getattr(AS_SHIPPED, name)}"].append(f"cycle: enabling input {name}")
    used[f"in:{AS_SHIPPED.reset}"].append("cycle: control reset")
    return used


def _telegrams(cell: Cell, used: dict[str, list[str]]) -> None:
    for telegram in cell.telegram:
        for field in telegram.fields:
            used[field.to].append(f"telegram {telegram.name} byte {field.byte} ({field.type})")
        for part in telegram.build:
            used[part.from_].append(f"telegram {telegram.name}")


def _searchable(entry: Entry) -> str:
    """Everything an entry can be found by; addresses also without their spaces."""
    tight = [each.replace(" ", "") for each in entry.addresses]
    return "\n".join((entry.name, entry.id, *entry.addresses, *tight, entry.en, entry.de, entry.group, *entry.used[:MOST_USED])).casefold()


def _is(entry: Entry, wanted: str) -> bool:
    return wanted == entry.name.casefold() or any(
        wanted == each.casefold() or wanted.replace(" ", "") == each.casefold().replace(" ", "") for each in entry.addresses
    )
