"""Out of a checked cell: which processes run, on which ports, with which regions (design: section 4)."""

import os
import pathlib
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.can.adapter_url import is_adapter
from gateway.assembly.contact_regions import chips, joined_regions, make_joined, reads_belts, simulated_couplers
from gateway.assembly.drive_buses import DRIVE_PROTOCOLS, listening
from gateway.assembly.lanes import lane_masks, lanes_of_cell
from gateway.assembly.pic import own_sources
from gateway.assembly.programs import ProgramPlan, plan_programs
from gateway.pure.cell.cell import Bus, Cell
from gateway.pure.cell.web import Web
from gateway.pure.image.records import cell as records
from gateway.pure.image.records import correction as correctionrecords
from gateway.pure.image.records import interpreter as interpreterrecords
from gateway.pure.image.records import planner as plannerrecords
from gateway.pure.image.records import plc as plcrecords
from gateway.pure.image.records.aside import ACYCLIC_RECORDS, ASIDE_BYTES, ASIDE_LAYOUT, HEARD_RECORDS
from gateway.pure.image.records.trace import TRACE_BYTES, TRACE_LAYOUT, TRACE_RECORDS
from gateway.pure.recording import messages
from gateway.pure.scope.records import SCOPE_LAYOUT, SCOPE_RECORDS, scope_bytes
from gateway.registry import LINE_LAYERS, language_in
from gateway.runtime import state_folder as statefolder
from gateway.runtime.regions import create_region, create_ring
from motion.execution.pieces import record_size

ORDERS = 256  # records in the command ring: far more than one command source can issue in a cycle
SOURCE_BYTES = 256  # command words (128 bytes at most) and status words (128) of one command source
LINKS_BYTES = 16384
MS = 1_000_000
WATCHED_MS: Mapping[str, int] = {  # processes without a region of their own: longest turn of their loops (AX-626)
    "gateway.simulation.bus.broker": 1_000,
    "gateway.processes.can_adapter": 5_000,  # some libraries need seconds to open
    "gateway.processes.web": 5_000,  # of low priority
    "gateway.processes.northbound": 5_000,
}
CYCLE_RINGS = ("trace", "scope", "record", "recorder")  # rings for listeners, and the region of the recorder
CHIPS_LIFE_MS = 1_000  # a chip on USB may be slow; its contacts are marked meanwhile
PLANNER_LIFE_MS = 10_000  # a law of a long run takes a second, much more on a busy computer; nothing depends on it meanwhile (AX-420)
INTERPRETER_LIFE_MS = 10_000  # a long program is checked for seconds
PROGRAM_REGIONS = ("interpreter", "channels", "program-orders", "program-says")
PLC_LIFE_MS = 2_000  # twice the longest scan the watchdog allows
PLC_REGIONS = ("plc", "plc-robot", "plc-shown", "plc-orders", "plc-says")
STRETCHED_LIFE_MS = 2_500  # of a cycle in a stretched simulation, which waits for its drives


@dataclass(frozen=True, slots=True)
class Child:
    """One process of a run."""

    name: str
    module: str
    arguments: tuple[str, ...] = ()
    regions: tuple[str, ...] = ()  # names of regions it gets as inherited fds
    life: str = ""  # the region whose life counter it beats; empty: only its exit counts
    life_limit_ns: int = 0
    announces: bool = False  # prints `ready` when it is
    spare: bool = False  # a loaded copy is ready and takes over when this one dies (AX-561)


@dataclass(frozen=True, slots=True)
class CommandSource:
    """A way in for commands: number in the blocks, name, kind line | modbus | pic."""

    number: int
    name: str
    kind: str


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Everything the processes of a run must agree on; pickled to the children of this very run."""

    slug: str
    cell: Cell
    simulated: bool
    folder: pathlib.Path
    p5_ms: int
    buses: Mapping[str, str]  # bus -> url of its CAN port
    lines: Mapping[str, str]  # line -> url of its byte port
    modbus: Mapping[str, tuple[str, int] | str]  # server -> host and port, or url of its serial port; client -> url
    sources: tuple[CommandSource, ...]
    record: pathlib.Path | None = None
    children: tuple[Child, ...] = field(default_factory=tuple)
    zeros: Mapping[str, float] = field(default_factory=dict)  # of absolute axes: increments at which they read 0
    web: Web | None = None  # the page, if the cell or the command line requests it
    programs: Mapping[int, ProgramPlan] = field(default_factory=dict)
    # Shadow: line -> ports that listen to the PLC and the old controller; Modbus server -> capture, address of the old controller.
    taps: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    stretched: bool = False  # simulated time waits for a computer that is late (AX-681)
    tolerances: Mapping[str, float] = field(default_factory=dict)  # of a shadow: positions of an axis so near to one another are equal

    @property
    def listening(self) -> tuple[str, ...]:
        """Buses nothing is sent on."""
        return listening(self.cell, simulated=self.simulated)

    def own_bus(self, name: str) -> bool:
        """Its port is a local bus of this very run (simulated, or an adapter's): no other run can be the master there."""
        return self.buses[name] == f"broker:{self.slug}-{name}"

    @property
    def journal(self) -> pathlib.Path:
        return statefolder.journal(self.folder, self.slug)

    def modbus_place(self, name: str) -> str:
        """Where that Modbus server or client is, in words."""
        place = self.modbus[name]
        return place if isinstance(place, str) else f"{place[0]}:{place[1]}"

    def source(self, name: str) -> CommandSource:
        """The command source of that name; KeyError names those that exist."""
        for source in self.sources:
            if source.name == name:
                return source
        raise KeyError(f"command source {name!r}; this cell has {', '.join(source.name for source in self.sources)}")


@dataclass(frozen=True, slots=True)
class Instead:
    """Replacements of a run for settings of its cell; None: as in the cell."""

    bus: str | None = None  # port of every drive bus
    p5_ms: int | None = None
    modbus_port: int | None = None  # of the first TCP server
    web_port: int | None = None


AS_THE_CELL = Instead()


def slug_of(cell: Cell) -> str:
    """Short name for sockets and folders: the file's stem, only letters, digits and dashes."""
    stem = pathlib.Path(cell.file).stem
    return "".join(c if c.isalnum() else "-" for c in stem).strip("-")[:24] or "cell"


def plan_run(
    cell: Cell,
    *,
    simulated: bool,
    slug: str | None = None,
    record: pathlib.Path | None = None,
    instead: Instead = AS_THE_CELL,
    stretched: bool = False,
) -> RunPlan:
    """Ports and processes of one run."""
    slug = slug or slug_of(cell)
    folder = runtime_dir() / slug
    folder.mkdir(mode=0o700, exist_ok=True)
    period_ms = instead.p5_ms or cell.cycle_ms
    buses, sims = bus_ports(cell, slug, instead.bus, period_ms, record, simulated=simulated)
    lines, simulators = line_ports(cell, slug, record, simulated=simulated)
    sims += simulators
    sims += emulators(cell, slug, folder, buses, period_ms, record, stretched=stretched) if simulated else []
    sources = tuple(
        CommandSource(n + 1, name, kind)
        for n, (name, kind) in enumerate(
            [(x.name, "line") for x in cell.line if LINE_LAYERS[x.layer].commands]
            + [(x.name, "modbus") for x in cell.modbus if x.role == "server"]
            + own_sources(cell)
        )
    )
    binds, cables = modbus_ports(cell, slug, simulated, instead.modbus_port)
    web = page_of(cell, instead.web_port, simulated=simulated)
    core = core_processes(cell, period_ms, sources, simulated=simulated, page=web is not None)
    if stretched:
        core[0] = replace(core[0], life_limit_ns=STRETCHED_LIFE_MS * MS)
    children, zeros, programs = watched((*sims, *cables, *core)), known_zeros(cell), plan_programs(cell)
    return RunPlan(
        slug, cell, simulated, folder, period_ms, buses, lines, binds, sources, record, children, zeros, web, programs, stretched=stretched
    )


def watched(children: Sequence[Child]) -> tuple[Child, ...]:
    """Processes without a region of their own get one for their life counter."""
    return tuple(
        replace(child, life=f"life-{n}", life_limit_ns=WATCHED_MS[child.module] * MS) if child.module in WATCHED_MS else child
        for n, child in enumerate(children)
    )


def bus_ports(
    cell: Cell, slug: str, bus: str | None, period_ms: int, record: pathlib.Path | None, *, simulated: bool
) -> tuple[dict[str, str], list[Child]]:
    """Port of each drive bus, and the processes to start before everything else; `bus` overrides the cell."""
    buses: dict[str, str] = {}
    children: list[Child] = []
    for drive_bus in cell.bus:
        if drive_bus.protocol not in DRIVE_PROTOCOLS:
            continue
        url = bus or drive_bus.port
        if bus is None and (simulated or drive_bus.port == "sim"):
            url = f"broker:{slug}-{drive_bus.name}"
            children.append(local_bus(drive_bus, url, record))
        elif is_adapter(url):
            if simulated:
                raise PortError(f"{url}: the emulated drives of --sim need a bus others can be on too: broker:NAME or socketcan:INTERFACE")
            local = f"broker:{slug}-{drive_bus.name}"
            children += adapter_children(
                drive_bus, local, url, period_ms, record, listens=drive_bus.name in listening(cell, simulated=False)
            )
            url = local
        buses[drive_bus.name] = url
    return buses, children


def line_ports(cell: Cell, slug: str, record: pathlib.Path | None, *, simulated: bool) -> tuple[dict[str, str], list[Child]]:
    """Where each serial line is, and the simulated ones."""
    lines: dict[str, str] = {}
    children: list[Child] = []
    for line in cell.line:
        lines[line.name] = line.port
        if simulated or line.port == "sim":
            name = f"{slug}-{line.name}"
            kept = ("--record", str(record / f"line-{line.name}.rec")) if record else ()
            arguments = ("--name", name, "--baud", str(line.baud), *kept)
            children.append(Child(f"line-{line.name}", "gateway.simulation.line.process", arguments, announces=True))
            lines[line.name] = f"pty:{runtime_dir() / name}-b"
    return lines, children


def core_processes(cell: Cell, period_ms: int, sources: Sequence[CommandSource], *, simulated: bool, page: bool) -> list[Child]:
    """Cycle, services and the further processes of this cell; `page`: it has one."""
    regions = ("rc_in", "rc_out", "axes", "links", "orders", "acyclic", "heard", *joined_regions(cell))
    blocks = [f"source-{source.number}" for source in sources]
    core = [
        Child("cycle", "gateway.cycle.loop", (), (*regions, *CYCLE_RINGS), "axes", max(5 * period_ms, 50) * MS),
        Child(
            "services",
            "gateway.services.loop",
            (),
            (*regions, "service_events", "recorder", *blocks),
            "links",
            250 * MS,
            spare=True,
        ),
    ]
    if cell.robot:
        core[0] = replace(core[0], regions=(*core[0].regions, "pieces", "pieces-taken", "planner"))
        core[1] = replace(core[1], regions=(*core[1].regions, "blocks", "planner"))
        own: tuple[str, ...] = ("axes", "blocks", "pieces", "pieces-taken", "planner")
        core.append(Child("planner", "gateway.processes.planner", (), own, "planner", PLANNER_LIFE_MS * MS))
    if cell.robot and language_in(cell) is not None:
        core[1] = replace(core[1], regions=(*core[1].regions, *PROGRAM_REGIONS))
        core[2] = replace(core[2], regions=(*core[2].regions, "lines"))
        own = ("axes", "planner", "lines", *PROGRAM_REGIONS, *(("belt_counters",) if reads_belts(cell) else ()))
        if _corrects(cell):
            core[0], own = replace(core[0], regions=(*core[0].regions, "correction")), (*own, "correction")
        core.append(Child("interpreter", "gateway.processes.interpreter", (), own, "interpreter", INTERPRETER_LIFE_MS * MS))
    if cell.controller is not None and cell.controller.plc is not None:
        core[1] = replace(core[1], regions=(*core[1].regions, *PLC_REGIONS))
        core.append(Child("plc", "gateway.processes.plc", (), ("rc_in", *PLC_REGIONS), "plc", PLC_LIFE_MS * MS))
    planner = ("planner",) if cell.robot else ()
    if page:
        core.append(Child("web", "gateway.processes.web", (), ("axes", "rc_in", "rc_out", "links", "scope", *planner)))
    if cell.northbound is not None:
        core.append(Child("northbound", "gateway.processes.northbound", (), ("axes", "rc_in", "rc_out", "links", *planner)))
    if chips(cell) and not simulated:
        core.append(
            Child("chips", "gateway.processes.gpio", (), ("axes", "rc_out", "links", "io_out", "io_chip"), "io_chip", CHIPS_LIFE_MS * MS)
        )
    return core


def local_bus(bus: Bus, url: str, record: pathlib.Path | None) -> Child:
    """The broker of that bus."""
    log = ("--log", str(record / f"bus-{bus.name}.log")) if record else ()
    return Child(f"broker-{bus.name}", "gateway.simulation.bus.broker", ("--name", url.partition(":")[2], *log), announces=True)


def adapter_children(bus: Bus, local: str, url: str, p5_ms: int, record: pathlib.Path | None, *, listens: bool) -> tuple[Child, Child]:
    """An adapter of python-can hangs on a local bus, because the cycle never waits for a library (AX-435)."""
    arguments = ("--bus", local, "--port", url, "--bitrate", str(bus.bits_per_s), "--fresh-ms", str(2 * p5_ms))
    mute = ("--listen-only",) if listens else ()
    return local_bus(bus, local, record), Child(f"adapter-{bus.name}", "gateway.processes.can_adapter", (*arguments, *mute), announces=True)


def page_of(cell: Cell, port: int | None, *, simulated: bool) -> Web | None:
    """Address of the page: as in [web], on loopback in a simulation, on `port` if the command line names it."""
    if cell.web is None and port is None:
        return None
    web = cell.web or Web()
    host = "127.0.0.1" if simulated else web.host
    shown = f"[{host}]" if ":" in host else host
    return replace(web, bind=f"{shown}:{web.port if port is None else port}")


def known_zeros(cell: Cell) -> dict[str, float]:
    """Zeros written by `axisgate axis zero` for this cell."""
    from gateway.assembly import axis_zeros as zeros

    found = {axis.name: zeros.zero_inc(cell, axis.name) for axis in cell.axis if axis.home.by == "none"}
    return {name: zero for name, zero in found.items() if zero is not None}


def emulators(
    cell: Cell,
    slug: str,
    folder: pathlib.Path,
    buses: Mapping[str, str],
    p5_ms: int,
    record: pathlib.Path | None,
    *,
    stretched: bool = False,
) -> list[Child]:
    """One emulator process for each drive bus, its plant written to a settings file."""
    from gateway.assembly.plant import belt_settings, write_settings  # the emulator's settings are only needed where one runs
    from gateway.assembly.rho3_buses import module_arguments

    children = []
    absent = cell.plant.absent if cell.plant else ()
    buses_with_io = {
        bus.name: modules
        for bus in cell.bus
        if bus.name in buses and bus.name not in absent and (modules := module_arguments(cell, bus, buses[bus.name]))
    }
    children += [
        Child(f"modules-{name}", "gateway.simulation.drives.io_modules", each, announces=True) for name, each in buses_with_io.items()
    ]
    children += coupler_children(cell, slug, buses)
    for name, url in buses.items():
        if not any(axis.drive.bus == name for axis in cell.axis):
            continue  # digital I/O only
        settings = write_settings(cell, name, folder, p5_ms)
        kept = ("--record", str(record / f"emulator-{name}.rec")) if record else ()
        arguments = ("--settings", str(settings), "--bus", url, "--name", f"{slug}-{name}", *kept)
        arguments += ("--stretched", str(p5_ms)) if stretched else ()
        arguments += ("--belts", belt_settings(cell, name)) if any(belt.bus == name for belt in cell.belt) else ()
        children.append(Child(f"emulator-{name}", "gateway.simulation.drives.process", arguments, announces=True))
    return children


def coupler_children(cell: Cell, slug: str, buses: Mapping[str, str]) -> list[Child]:
    """One process for the emulated CiA 401 couplers of each bus."""
    return [
        Child(f"couplers-{name}", "gateway.simulation.drives.couplers", arguments, announces=True)
        for name, arguments in simulated_couplers(cell, slug, buses).items()
    ]


def _corrects(cell: Cell) -> bool:
    """Whether the application alters the path."""
    return cell.alter is not None and cell.alter.source == "application" and cell.val3 is not None


def make_regions(plan: RunPlan) -> dict[str, int]:
    """One memfd per region and ring; the supervisor keeps them for its lifetime."""
    axes, lanes = len(plan.cell.axis), lanes_of_cell(plan.cell)
    fds = {
        "rc_in": create_region("rc_in", records.INPUT_SIZE, records.INPUT_LAYOUT),
        "rc_out": create_region("rc_out", records.RC_BYTES, f"rc-out/1 {records.RC_BYTES}"),
        "axes": create_region("axes", records.cell_state_size(axes, lanes), records.CELL_STATE_LAYOUT),
        "links": create_region("links", LINKS_BYTES, "links/1 json"),
        "orders": create_ring("orders", records.order_size(record_size(axes)), ORDERS, records.ORDER_LAYOUT),
    }
    fds["acyclic"] = create_ring("acyclic", ASIDE_BYTES, ACYCLIC_RECORDS, ASIDE_LAYOUT)
    fds["heard"] = create_ring("heard", ASIDE_BYTES, HEARD_RECORDS, ASIDE_LAYOUT)
    fds["scope"] = create_ring("scope", scope_bytes(axes, lanes), SCOPE_RECORDS, SCOPE_LAYOUT)
    fds["record"] = create_ring("record", messages.CHUNK_BYTES, messages.CHUNK_RECORDS, messages.CHUNK_LAYOUT)
    fds["service_events"] = create_ring(
        "service_events", messages.SERVICE_EVENT_BYTES, messages.SERVICE_EVENT_RECORDS, messages.SERVICE_EVENT_LAYOUT
    )
    fds["recorder"] = create_region("recorder", messages.ASKED.size, messages.ASKED_LAYOUT)
    fds["trace"] = create_ring("trace", TRACE_BYTES, TRACE_RECORDS, TRACE_LAYOUT)
    if plan.cell.robot:
        fds["blocks"] = create_ring("blocks", plannerrecords.SAY_SIZE, plannerrecords.BLOCKS, plannerrecords.SAY_LAYOUT)
        fds["pieces"] = create_ring("pieces", plannerrecords.piece_size(axes), plannerrecords.PIECES, plannerrecords.PIECE_LAYOUT)
        fds["pieces-taken"] = create_region("pieces-taken", plannerrecords.TAKEN_SIZE, plannerrecords.TAKEN_LAYOUT)
        fds["planner"] = create_region("planner", plannerrecords.planner_bytes(len(lane_masks(plan.cell))), "planner/1 json")
    if any(child.name == "interpreter" for child in plan.children):
        texts = interpreterrecords.TEXT_SIZE, interpreterrecords.RECORDS, interpreterrecords.TEXT_LAYOUT
        fds["interpreter"] = create_region("interpreter", interpreterrecords.REPORT_BYTES, interpreterrecords.REPORT_LAYOUT)
        fds["channels"] = create_region("channels", interpreterrecords.SEEN_SIZE, interpreterrecords.SEEN_LAYOUT)
        fds["program-orders"] = create_ring("program-orders", *texts)
        fds["program-says"] = create_ring("program-says", *texts)
        fds["lines"] = create_ring("lines", plannerrecords.SAY_SIZE, plannerrecords.BLOCKS, plannerrecords.SAY_LAYOUT)
        if _corrects(plan.cell):
            fds["correction"] = create_region("correction", correctionrecords.CORRECTION_SIZE, correctionrecords.CORRECTION_LAYOUT)
    if any(child.name == "plc" for child in plan.children):
        texts = interpreterrecords.TEXT_SIZE, plcrecords.ORDERS, interpreterrecords.TEXT_LAYOUT
        fds["plc"] = create_region("plc", plcrecords.PLC_SIZE, plcrecords.PLC_LAYOUT)
        fds["plc-robot"] = create_region("plc-robot", plcrecords.ROBOT_SIZE, plcrecords.ROBOT_LAYOUT)
        fds["plc-shown"] = create_region("plc-shown", plcrecords.SHOWN_SIZE, plcrecords.SHOWN_LAYOUT)
        fds |= {name: create_ring(name, *texts) for name in ("plc-orders", "plc-says")}
    fds |= {child.life: create_region(child.life, 8) for child in plan.children if child.module in WATCHED_MS and child.life}
    fds |= make_joined(plan.cell)
    for source in plan.sources:
        fds[f"source-{source.number}"] = create_region(f"source-{source.number}", SOURCE_BYTES, f"source/1 {SOURCE_BYTES}")
    return fds


def modbus_ports(cell: Cell, slug: str, simulated: bool, port: int | None) -> tuple[dict[str, tuple[str, int] | str], list[Child]]:
    """Ports of Modbus servers and clients, and the cables of simulated lines; `port` is the first TCP server's."""
    places: dict[str, tuple[str, int] | str] = {}
    cables: list[Child] = []
    for modbus in cell.modbus:
        if modbus.serial and (simulated or modbus.port_ == "sim"):
            name = f"{slug}-{modbus.name}"
            arguments = ("--name", name, "--baud", modbus.format.split()[0], "--plain", "A")
            cables.append(Child(f"line-{modbus.name}", "gateway.simulation.line.process", arguments, announces=True))
            places[modbus.name] = f"pty:{runtime_dir() / name}-b"
        elif modbus.port_:
            places[modbus.name] = modbus.port_
        else:
            own = modbus.port if not simulated or modbus.port >= 1024 else 1000 + modbus.port  # 502 and 802 need a permission
            places[modbus.name] = ("127.0.0.1" if simulated else modbus.host, own if port is None else port)
            port = None
    return places, cables


def load_plan(fd: int) -> RunPlan:
    """The plan our own supervisor wrote into a memfd; read without moving the offset all its children share."""
    plan = pickle.loads(os.pread(fd, os.fstat(fd).st_size, 0))
    assert isinstance(plan, RunPlan)
    return plan
