"""Data blocks: places, types, names, ranges, who writes which word, and the bits of the handshakes."""

from gateway.assembly.data_block_signals import flag_operand, number_of, operand, parsed, place_of, rc_place
from gateway.assembly.lanes import several
from gateway.checks.context import Context, near, number
from gateway.checks.controller import names_of, phg_fault
from gateway.pure.cell.cell import Axis, Db, Entry, Handshake
from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX
from gateway.pure.image.addresses import AddressFault, DataBit, DataWord, Direction, Operand, Part, bits_of, parse
from gateway.pure.image.names import Found, Kind, lookup, spelled
from gateway.pure.image.reasons import Reason
from gateway.registry import LINE_LAYERS, MODBUS_VIEWS

DOUBLE = ("DH", "KG", "REAL")
FULL = 100.0  # %
NEEDED = {  # bits a handshake pattern cannot do without
    "start-busy-done": ("start", "busy", "done"),
    "level-ack": ("start", "done"),
    "toggle": ("start", "done"),
    "strobe-parity": ("start", "done"),
    "number-select": ("done",),
}
CARRIED: dict[str, set[str]] = {  # names its telegrams have to carry
    "start-busy-done": {"move.start"},
    "level-ack": {"move.start"},
    "toggle": {"move.start"},
    "strobe-parity": {"move.start", "move.number", "move.parity"},
    "number-select": {"move.number"},
}
LARGEST = {"cell.life": 0x7FFF, "error.first.code": max(Reason)}  # numbers of ours and their largest value
BYTE = ("KH", "KM", "KF", "KC")
COUNTS = {  # type -> smallest and largest count of an integer (STEP 5)
    "KF": (-32768, 32767),
    "KH": (0, 65535),
    "KM": (0, 65535),
    "KZ": (0, 999),
    "KT": (0, 999),
    "BCD": (0, 9999),
    "DH": (-(2**31), 2**31 - 1),
}


def serving_layers() -> str:
    """Names of the line layers that serve data blocks, for a hint."""
    return ", ".join(name for name, layer in LINE_LAYERS.items() if layer.blocks)


def split_unit(text: str) -> tuple[float, str]:
    """ "0.1 mm" -> (0.1, "mm")."""
    factor, _, unit = text.partition(" ")
    return float(factor), unit


def counts_of(entry: Entry, address: DataWord | DataBit) -> tuple[float, float] | None:
    """Smallest and largest count an entry can hold; None for floats and bits."""
    if isinstance(address, DataWord) and address.part in (Part.LEFT, Part.RIGHT):
        return 0, 255
    return COUNTS.get(entry.type)


def _key(block: Db, entry: Entry) -> str:
    return f"db.{block.number}[{entry.at}]"


def block_heads(check: Context) -> None:
    """Block numbers are unique; every block belongs to a line that serves blocks."""
    seen: set[tuple[str, str, int]] = set()
    for block in check.cell.db:
        if (block.line, block.kind, block.number) in seen:
            check.fault(f"db.{block.number}.number", block.number, "this block is defined twice; put its entries into one table")
        seen.add((block.line, block.kind, block.number))
        if (block.kind in "DX") is (block.number == 0):
            hint = "a data block has a number" if block.kind in "DX" else f'kind = "{block.kind}" is one area: number = 0'
            check.fault(f"db.{block.number}.number", block.number, hint, "1..255" if block.kind in "DX" else "0")
        lines = {line.name: line for line in check.cell.line}
        if not block.line:
            check.fault(
                f"db.{block.number}.line",
                "",
                'which line is it served on? write line = ".." (several lines could)'
                if any(LINE_LAYERS[line.layer].blocks for line in lines.values())
                else f"no [[line]] serves data blocks; layers that do: {serving_layers()}",
            )
        elif (
            not check.unknown(f"db.{block.number}.line", block.line, "line")
            and block.line in lines
            and not LINE_LAYERS[lines[block.line].layer].blocks
        ):
            hint = f'layer "{lines[block.line].layer}" serves no data blocks; layers that do: {serving_layers()}'
            check.fault(f"db.{block.number}.line", block.line, hint)


def places(check: Context) -> None:
    """Every `at` is a place inside the block that fits the type, and no bit is covered twice."""
    for block in check.cell.db:
        covered: dict[int, Entry] = {}
        for entry in block.entries:
            address = _place(check, block, entry)
            if address is None:
                continue
            bits = bits_of(address)
            if bits.stop > block.words * 16:
                check.fault(_key(block, entry), entry.at, f"beyond the block: it has {block.words} words", f"word 0..{block.words - 1}")
                continue
            other = next((covered[bit] for bit in bits if bit in covered), None)
            if other is not None and address != place_of(block, other):
                first = next(bit for bit in bits if bit in covered)
                check.fault(_key(block, entry), entry.at, f"overlaps {other.at} ({other.signal}): both cover D {first // 16}.{first % 16}")
            elif other is not None:
                check.fault(_key(block, entry), entry.at, f"two entries at one address: {other.signal} and {entry.signal}")
            covered.update(dict.fromkeys(bits, entry))


def _place(check: Context, block: Db, entry: Entry) -> DataWord | DataBit | None:
    try:
        address = parsed(block, entry)
    except AddressFault as error:
        check.fault(_key(block, entry), entry.at, str(error).split(": ", 1)[-1])
        return None
    if not isinstance(address, DataWord | DataBit) or address.db != number_of(block):
        check.fault(_key(block, entry), entry.at, f'a place in DB {block.number}: "DW 2", "DL 2", "DR 2", "DD 2", "D 0.3"')
        return None
    if isinstance(address, DataBit) is not (entry.type == "bit"):
        check.fault(_key(block, entry), entry.type, 'a bit has the address "D word.bit" and type "bit", everything else DW, DL, DR or DD')
        return None
    if isinstance(address, DataWord):
        wanted = (Part.DOUBLE,) if entry.type in DOUBLE else (Part.WORD, Part.LEFT, Part.RIGHT) if entry.type in BYTE else (Part.WORD,)
        if address.part not in wanted:
            check.fault(
                _key(block, entry), entry.type, f"{entry.type} needs an address of {' or '.join(part.value for part in wanted)}", "", ""
            )
            return None
    return address


def writers(check: Context) -> None:
    """`to` only in blocks the PLC writes, `from` only in blocks of the cell; each value has one writer."""
    written: dict[str, str] = {}
    for block in check.cell.db:
        if block.writer not in ("plc", "axisgate"):
            _of_modbus(check, block)
            continue
        for entry in block.entries:
            key = _key(block, entry)
            if (entry.to is None) == (entry.from_ is None):
                check.fault(key, "", 'exactly one of to = ".." (the PLC writes) and from = ".." (axisgate writes)')
                continue
            if (entry.to is None) is (block.writer == "plc"):
                other = "to" if block.writer == "plc" else "from"
                hint = f'two writers in one word: writer = "{block.writer}", so entries have {other} = ".."'
                check.fault(key, entry.signal, hint)
            if entry.to and not entry.to.endswith(".target"):  # targets may be in several blocks: the latest telegram counts (AX-122)
                if entry.to in written:
                    check.fault(key, entry.to, f"{written[entry.to]} writes it already")
                written.setdefault(entry.to, key)


def _of_modbus(check: Context, block: Db) -> None:
    """AX-479: the clients of a Modbus server write it by FC 21; routes read it, the line fetches it."""
    key = f"db.{block.number}"
    server = next((source for source in check.cell.modbus if source.name == block.writer and source.role == "server"), None)
    if server is None:
        there = ", ".join(source.name for source in check.cell.modbus if source.role == "server")
        check.fault(
            f"{key}.writer", block.writer, f'no such writer: "plc", "axisgate" or a Modbus server ({there or "this cell has none"})'
        )
    elif not any(MODBUS_VIEWS[view].signals for view in (server.view, *(unit.view for unit in server.units))):
        check.fault(f"{key}.writer", block.writer, 'this server has no files: they belong to the view "rho3"')
    if block.kind != "D":
        check.fault(f"{key}.kind", block.kind, "file N is data block N: only kind D has files")
    if block.entries:
        check.fault(key, block.entries[0].signal, "a block that Modbus clients write has no entries: a [[route]] reads its words")


def names(check: Context) -> None:
    """Every to and from is a known name of the right kind and direction."""
    suggestions = spelled(sorted(check.known["axis"]), sorted(check.known["line"]), sorted(check.known["robot"]))
    for block in check.cell.db:
        for entry in block.entries:
            place = rc_place(entry.signal, check.signals)
            if place is not None:
                wrong = place.direction is Direction.OUTPUT and entry.to is not None
                if wrong or entry.type != "bit":
                    hint = "an RC output is read with from, an RC input written with to" if wrong else 'a signal is a bit: type = "bit"'
                    check.fault(_key(block, entry), entry.signal, hint)
                continue
            found = lookup(entry.signal)
            if found is None and check.cell.controller is not None and _of_control(check, entry):
                continue
            if found is None:
                hint = phg_fault(check.cell, entry.signal) or (
                    near(entry.signal, suggestions)
                    or f"known are {', '.join(spelled(['AXIS'], ['LINE'], ['ROBOT']))} and the signals of the RC list"
                )
                check.fault(_key(block, entry), entry.signal, f"unknown name; {hint}")
                continue
            _kind(check, block, entry, found)


def _of_control(check: Context, entry: Entry) -> bool:
    """A flag, timer, counter, byte or word of the control, or one of its values; flags alone are written."""
    if entry.to is not None:
        return flag_operand(entry.to) is not None
    if entry.signal.startswith(PREFIX):
        return not phg_fault(check.cell, entry.signal)
    return isinstance(operand(entry.signal), Operand) or entry.signal in names_of(check.cell)


def _kind(check: Context, block: Db, entry: Entry, found: Found) -> None:
    key = _key(block, entry)
    if found.which and found.which != "*":
        if check.unknown(key, found.which, found.kind):
            return
        if found.kind == "robot" and entry.to and not several(check.cell):
            check.fault(key, entry.signal, "the cell has one kinematic only, or a [[robot]] without a model; use cell.override")
    if not (found.name.to if entry.to else found.name.from_):
        way = "read (from = ..)" if entry.to else "written (to = ..)"
        check.fault(key, entry.signal, f"this name is only {way}")
    if (found.name.kind is Kind.BIT) is not (entry.type == "bit"):
        check.fault(key, entry.type, f"{entry.signal} is a {'bit' if found.name.kind is Kind.BIT else 'number'}")
    if found.which == "*" and found.name.kind is Kind.WAY:
        check.fault(key, entry.signal, "one address holds one axis: name it instead of *")
    if entry.edge and found.name.kind is not Kind.BIT:
        check.fault(key, entry.edge, "only bits have edges")


def ranges(check: Context) -> None:
    """min < max, both hold in the type, the unit fits, and the axis' travel fits the counts."""
    axes = {axis.name: axis for axis in check.cell.axis}
    for block in check.cell.db:
        for entry in block.entries:
            address, found = place_of(block, entry), lookup(entry.signal)
            factor, unit = split_unit(entry.unit)
            if entry.min is not None and entry.max is not None and entry.min >= entry.max:
                check.fault(_key(block, entry), f"min {number(entry.min)}, max {number(entry.max)}", "min must be below max")
            if factor <= 0:
                check.fault(_key(block, entry), entry.unit, 'one count must be greater than 0: unit = "0.1 mm"')
                continue
            counts = counts_of(entry, address) if address else None
            if counts:
                _bounds(check, block, entry, factor, counts)
                _overflow(check, block, entry, found, factor, counts[1])
            if found and found.name.kind is Kind.WAY and found.which in axes:
                _travel(check, block, entry, axes[found.which], (factor, unit), counts)


def _overflow(check: Context, block: Db, entry: Entry, found: Found | None, factor: float, most: float) -> None:
    """Compare the largest value of a name with the largest count."""
    if found is None:
        return
    if found.name.kind is Kind.PERCENT and entry.max is None and most * factor < FULL:
        text = (
            f"{entry.type} at {entry.unit} ends at {number(most * factor)} %, {entry.signal} goes to {FULL:g} %: use a coarser unit or DH"
        )
        check.fault(_key(block, entry), entry.unit, text, f">= {number(FULL / most)}", "% a count")
    largest = LARGEST.get(entry.signal)
    if largest is not None and most * factor < largest:
        text = f"{entry.signal} goes to {largest}; {entry.type} at {entry.at} ends at {number(most * factor)} and would stop there"
        check.fault(_key(block, entry), entry.type, text)


def _bounds(check: Context, block: Db, entry: Entry, factor: float, counts: tuple[float, float]) -> None:
    for name, bound in (("min", entry.min), ("max", entry.max)):
        if bound is not None and not counts[0] * factor <= bound <= counts[1] * factor:
            span = f"{number(counts[0] * factor)}..{number(counts[1] * factor)}"
            check.fault(
                _key(block, entry),
                f"{name} = {number(bound)}",
                f"{entry.type} at {entry.unit} cannot hold it",
                span,
                split_unit(entry.unit)[1],
            )


def _travel(check: Context, block: Db, entry: Entry, axis: Axis, unit: tuple[float, str], counts: tuple[float, float] | None) -> None:
    if unit[1] != axis.unit:
        check.fault(_key(block, entry), entry.unit, f'axis {axis.name} is in {axis.unit}: write unit = "0.1 {axis.unit}" (one count)')
        return
    if counts is None:
        return
    low, high = counts[0] * unit[0], counts[1] * unit[0]
    if low > axis.limits.min or high < axis.limits.max:
        travel = f"{number(axis.limits.min)}..{number(axis.limits.max)}"
        reach = f"{entry.type} at {entry.unit} reaches {number(low)}..{number(high)} {axis.unit}"
        hint = f"{reach}; axis {axis.name} goes {travel} {axis.unit}: use a coarser unit or DH"
        check.fault(_key(block, entry), entry.unit, hint)


def handshakes(check: Context) -> None:
    """Start is a bit the PLC writes, busy, done and refused are bits we write."""
    for name, shake in check.cell.handshake.items():
        for key, writer in (("start", "plc"), ("busy", "axisgate"), ("done", "axisgate"), ("refused", "axisgate")):
            text = getattr(shake, key)
            if text:
                _bit(check, f"handshake.{name}.{key}", text, writer)
            elif key in NEEDED[shake.pattern]:
                check.fault(f"handshake.{name}.{key}", text, f'pattern = "{shake.pattern}" needs this bit, as DB10.D0.8')
        if name != "move":
            check.fault(f"handshake.{name}", name, "only [handshake.move] exists")
        _targets(check, shake)


def _targets(check: Context, shake: Handshake) -> None:
    written = {entry.to for block in check.cell.db for entry in block.entries if entry.to}
    numbers = shake.pattern in ("number-select", "strobe-parity") and bool(check.cell.program)
    wanted = numbers or any(name.endswith(".target") for name in written) or bool(check.cell.position)
    for name in CARRIED[shake.pattern] - written:
        check.fault("handshake.move.pattern", shake.pattern, f'no entry writes to = "{name}"')
    if shake.pattern == "number-select" and not (check.cell.position or check.cell.program):
        check.fault("handshake.move.pattern", shake.pattern, "no [[position]] and no [[program]]: what should a number select?")
    if not wanted and check.cell.db:
        check.fault("handshake.move", shake.start, 'no entry writes a target (to = "move.AXIS.target"): what should it start?')


def _bit(check: Context, key: str, text: str, writer: str) -> None:
    try:
        address = parse(text)
    except AddressFault as error:
        check.fault(key, text, str(error).split(": ", 1)[-1])
        return
    if not isinstance(address, DataBit):
        check.fault(key, text, "a bit of a data block, as DB10.D0.8")
        return
    blocks = [block for block in check.cell.db if block.kind == "D" and block.number == address.db]
    if not blocks:
        check.unknown(key, str(address.db), "db")
        return
    if blocks[0].writer != writer:
        check.fault(key, text, f'DB {address.db} has writer = "{blocks[0].writer}"; this bit is written by {writer}')
    elif not any(place_of(blocks[0], entry) == address for entry in blocks[0].entries):
        check.fault(key, text, f'DB {address.db} has no entry at "D {address.word}.{address.bit}"')


def positions(check: Context) -> None:
    """Numbers are unique, among the programs too; axes exist, targets lie inside the travel."""
    axes = {axis.name: axis for axis in check.cell.axis}
    programs = {program.number for program in check.cell.program}
    seen: set[int] = set()
    for position in check.cell.position:
        key = f"position.{position.number}"
        if position.number in seen:
            check.fault(f"{key}.number", position.number, "this number is used twice")
        seen.add(position.number)
        if position.number in programs:
            check.fault(f"{key}.number", position.number, "a [[program]] has this number: which one should it select?")
        for name, target in position.at.items():
            if check.unknown(f"{key}.at", name, "axis") or name not in axes:
                continue
            limits = axes[name].limits
            if not limits.min <= target <= limits.max:
                span = f"{number(limits.min)}..{number(limits.max)}"
                check.fault(f"{key}.at", f"{name} = {number(target)}", "outside the axis' limits", span, axes[name].unit)


CHECKS = (block_heads, places, writers, names, ranges, handshakes, positions)
