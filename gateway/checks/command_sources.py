"""Head, safety fields, lines, Modbus servers, RC input bytes: connections and unique names."""

from gateway.assembly.axis_signals import SINGLE
from gateway.assembly.data_block_signals import rc_place
from gateway.assembly.lanes import several
from gateway.assembly.pic import own_sources
from gateway.checks.context import Context, near, program_lines, twice
from gateway.pure.cell.cell import Line
from gateway.pure.image.addresses import AddressFault, DataWord, Direction, RcBit, parse
from protocols.p3964r.profiles import NETWORK, PROFILES

FREE_PORTS = ("sim",)
MOVABLE = (
    *("EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"),
    *("READY_RCO", "READY2_RCO", "DRIVES_ON_RCO", "EMSTOP_RCO", "INPOS_1_RCO", "REF_1_RCO"),
)
ENABLING = ("EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI")  # AX-002, bits 24..28


def safety(check: Context) -> None:
    """`run` on real drives requires every field of [safety] (users.md 3.4)."""
    if check.cell.cell.target != "machine":
        return
    table = check.cell.safety
    if table is None:
        check.fault("safety", hint='target = "machine" needs the [safety] table: emergency_stop, sto_wired, guard, limit_switches, ...')
        return
    for name in ("emergency_stop", "sto_wired", "guard", "limit_switches", "risk_assessment", "last_stop_test"):
        if getattr(table, name) in ("", None):
            check.fault(f"safety.{name}", "empty", 'target = "machine" needs it: what does the plant guarantee in hardware?')


def names(check: Context) -> None:
    """No two command sources, buses, axes or contacts with one name; no port used twice."""
    cell = check.cell
    sources = [(line.name, f"line.{line.name}") for line in cell.line] + [(source.name, f"modbus.{source.name}") for source in cell.modbus]
    sources += [(name, f"controller.{name}") for name, _ in own_sources(cell)]
    _unique(check, [(name, place, "") for name, place in sources], "command sources")
    kinds = (("bus", [bus.name for bus in cell.bus]), ("axis", [axis.name for axis in cell.axis]), ("io", [io.name for io in cell.io]))
    for kind, parts in kinds:
        named = [(name, f"{kind}.{name}", f"{kind}[{index}].name") for index, name in enumerate(parts)]
        _unique(check, named, f"[[{kind}]] tables")
    ports = [(line.port, f"line.{line.name}.port") for line in cell.line] + [(bus.port, f"bus.{bus.name}.port") for bus in cell.bus]
    for value, first, place in twice((port, place) for port, place in ports if port not in FREE_PORTS):
        check.fault(place, value, f"{first} already has this port")
    for value, first, place in twice(
        (source.bind, f"modbus.{source.name}.bind")
        for source in cell.modbus
        if source.port and source.role == "server" and not source.serial
    ):
        check.fault(place, value, f"{first} already listens there")


def _unique(check: Context, named: list[tuple[str, str, str]], what: str) -> None:
    """`named`: name, key by name, key by number; the line is that of the second table of a name."""
    seen: set[str] = set()
    for name, place, at in named:
        if name in seen:
            check.fault(f"{place}.name", name, f"the name is used twice among the {what}", at=at)
        seen.add(name)


def lines(check: Context) -> None:
    """Profile known, layer fits, life word is an entry the PLC counts up."""
    for line in check.cell.line:
        if line.profile.removesuffix(NETWORK) not in PROFILES:
            bare = line.profile.removesuffix(NETWORK)
            hint = near(bare, PROFILES, most=3) or f"behind a serial server: with {NETWORK} at the end"
            check.fault(f"line.{line.name}.profile", line.profile, hint, " | ".join(sorted(PROFILES)))
        if line.output_timeout is not None and (line.output_timeout == -1) is not (line.priority == "low"):
            hint = f"output_timeout = {line.output_timeout} means the opposite (-1 = low): keep one of them"
            check.fault(f"line.{line.name}.priority", line.priority, hint)
        if not line.format.split()[1].startswith("8"):
            check.fault(f"line.{line.name}.format", line.format, "3964R carries all 256 characters: 8 data bits", '"9600 8E1"')
        if line.supervision.life_word is not None:
            _life_word(check, line, line.supervision.life_word)


def _life_word(check: Context, line: Line, text: str) -> None:
    key = f"line.{line.name}.supervision.life_word"
    try:
        address = parse(text)
    except AddressFault as error:
        check.fault(key, text, str(error))
        return
    if not isinstance(address, DataWord):
        check.fault(key, text, "the life word is a data word of a block the PLC sends, as DB10.DW31")
        return
    if check.unknown(key, str(address.db), "db"):
        return
    entries = [entry for block in check.cell.db if block.kind == "D" and block.number == address.db for entry in block.entries]
    wanted = f"line.{line.name}.life"
    here = [entry for entry in entries if entry.to and _same(entry.at, address)]
    if entries and not any(entry.to == wanted for entry in here):
        check.fault(key, text, f'DB {address.db} has no entry {{ at = "DW {address.word}", type = "KF", to = "{wanted}" }}')


def _same(at: str, address: DataWord) -> bool:
    try:
        return parse(at, db=address.db) == address
    except AddressFault:
        return False


def rc_inputs(check: Context) -> None:
    """Every RC input byte has one owning command source; assumed inputs are enabling inputs."""
    sources = (check.known["line"] - program_lines(check.cell)) | check.known["modbus"] | {name for name, _ in own_sources(check.cell)}
    for byte, source in check.cell.rc_inputs.owner.items():
        if byte > 127:
            check.fault("rc_inputs.owner", byte, "", "0..127", "PIC byte")
        if source not in sources:
            check.fault(
                "rc_inputs.owner",
                f"{byte} = {source}",
                f"no such command source; {near(source, sources) or 'there is ' + ', '.join(sorted(sources))}",
            )
    owners = dict(check.cell.rc_inputs.owner)
    for block in check.cell.db:
        for entry in block.entries:
            place = rc_place(entry.to, check.signals) if entry.to else None
            if place is None or place.direction is not Direction.INPUT:
                continue
            byte = place.number // 8
            if owners.setdefault(byte, block.line) != block.line:
                hint = f"two writers in RC input byte {byte}: {owners[byte]} owns it, {block.line} writes {entry.to} into it"
                check.fault(f"db.{block.number}[{entry.at}]", entry.to or "", hint)
    for name in check.cell.rc_inputs.assume:
        if name not in ENABLING:
            check.fault(
                "rc_inputs.assume", name, f"only enabling inputs may be assumed; {near(name.upper(), ENABLING)}", " | ".join(ENABLING)
            )
    _wired(check)


def _wired(check: Context) -> None:
    """Feed inputs of single kinematics: of one of several (AX-1787)."""
    for name in check.cell.rc_inputs.wired:
        signal = check.signals.named(name)
        row = SINGLE.fullmatch(signal.name) if signal is not None else None
        if row is None:
            check.fault("rc_inputs.wired", name, "names feed inputs of single kinematics", "KIN_n_FEED_ALLOW_RCI | KIN_n_FEED_HOLD_N_RCI")
        elif int(row[1]) > len(check.cell.robot):
            check.fault("rc_inputs.wired", name, f"the cell has {len(check.cell.robot)} kinematics", f"1..{len(check.cell.robot)}")
        elif not several(check.cell):
            hint = "the cell has one kinematic only, or a [[robot]] without a model; use FEED_ALLOW_RCI and FEED_HOLD_N_RCI"
            check.fault("rc_inputs.wired", name, hint)


def signals(check: Context) -> None:
    """Only axisgate's own numbers can be moved, to places the manual leaves free, each to a place of its own."""
    moved = {name.upper(): bit for name, bit in check.cell.signals.items()}
    taken = {signal.at: signal.name for signal in check.signals.all if signal.name not in moved and not signal.until}
    for name, bit in moved.items():
        signal = check.signals.named(name)
        if signal is None or (signal.source != "axisgate" and bit != signal.printed):
            check.fault(
                f"signals.{name}", bit, "only axisgate's own signals can be moved (AX-002); the manual's numbers stay", " | ".join(MOVABLE)
            )
            continue
        place = RcBit(signal.at.direction, bit)
        if place in taken:
            check.fault(f"signals.{name}", bit, f"already used by {taken[place]}")
        taken[place] = name


CHECKS = (safety, names, lines, rc_inputs, signals)
