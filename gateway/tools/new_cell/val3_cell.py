"""The text of a cell out of a flash card: [val3] with its channels, the points its applications link to, limits of the axes (AX-990)."""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from gateway.pure.languages.val3.card import Card, CardChannel
from gateway.pure.languages.val3.links import Link

FIRST_BIT, LAST_BIT, RUN_BIT, LAST_BYTE = 704, 1023, 711, 126
STEPS = 100  # of an analog value: two decimals within -327..327
RANGE = 327.0
SECTION = re.compile(r"^\[", re.M)


@dataclass(frozen=True, slots=True)
class Parts:
    """Facts from the card.  rest: the drives, robot and plant of a cell of that arm, from [rc_inputs] on."""

    card: Card
    application: str
    disk: str  # folder that is Disk://, as the cell file names it
    system: str
    links: tuple[Link, ...]
    rest: str
    source: str  # the card, for the first line
    alters: bool = False  # a program has alterBegin


@dataclass(slots=True)
class _Points:
    """Assigns addresses to points in sequence."""

    rows: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    _bits: dict[bool, int] = field(default_factory=lambda: {False: FIRST_BIT, True: FIRST_BIT})
    _bytes: dict[bool, int] = field(default_factory=lambda: {False: LAST_BYTE, True: LAST_BYTE})

    def add(self, link: Link) -> None:
        """One system input or output."""
        if self._bits[link.output] // 8 >= self._bytes[link.output] - 1:
            self.lost.append(link.path)
            return
        board, module, address = place_of(link.path)
        name = self._name(address, link.variable)
        row = [f"name    = {quoted(name)}", f"board   = {quoted(board)}", f"module  = {quoted(module)}", f"address = {quoted(address)}"]
        if link.analog:
            row.append(f"byte    = {self._bytes[link.output]}\nsteps   = {STEPS}\nmin     = {-RANGE}\nmax     = {RANGE}")
            self._bytes[link.output] -= 2
        else:
            bit = self._bits[link.output]
            bit += bit == RUN_BIT and not link.output
            row.append(f"bit     = {bit}")
            self._bits[link.output] = bit + 1
        row += ["output  = true"] if link.output else []
        self.rows.append("[[controller.point]]\n" + "\n".join(row) + "\n")

    def _name(self, address: str, variable: str) -> str:
        wanted = address if re.fullmatch(r"[A-Za-z]\w*", address, re.ASCII) else re.sub(r"\W", "_", variable) or "point"
        wanted = wanted if wanted[0].isalpha() else f"p{wanted}"
        name, count = wanted, 1
        while name.lower() in self.names:
            count += 1
            name = f"{wanted}_{count}"
        self.names.add(name.lower())
        return name


def place_of(path: str) -> tuple[str, str, str]:
    """Board, module and address of a link: `ValveIO\\valve1`, `board\\module\\address`, `valve1`."""
    parts = [part for part in path.replace("/", "\\").split("\\") if part] or ["point"]
    if len(parts) == 1:
        return "System", "io", parts[0]
    return parts[0], "\\".join(parts[1:-1]) or "io", parts[-1]


def distinct(links: Iterable[Link]) -> list[Link]:
    """Each system input or output once: `valve1` is the last name of `ValveIO\\valve1`."""
    found: list[Link] = []
    for link in sorted(links, key=lambda each: not {"/", "\\"} & set(each.path)):
        path = link.path.lower().replace("/", "\\")
        known = [each.path.lower().replace("/", "\\") for each in found]
        same = (at for at, own in enumerate(known) if own == path or ("\\" not in path and own.rpartition("\\")[2] == path))
        if (at := next(same, None)) is None:
            found.append(link)
        elif link.output and not found[at].output:  # another variable of it is written
            found[at] = replace(found[at], output=True)
    return found


def cell_of(parts: Parts) -> tuple[str, list[str]]:
    """The text of the cell, and the remaining tasks of the user."""
    points, doubts = _Points(), list(parts.card.doubts)
    links = distinct(parts.links)
    for link in links:
        points.add(link)
    known = {place_of(link.path)[2].lower() for link in links}
    for signal in parts.card.signals:
        if signal.name.lower() not in known:
            points.add(Link(f"{signal.board}\\{signal.module}\\{signal.name}", signal.output, signal.analog, signal.name))
            known.add(signal.name.lower())
    if points.lost:
        doubts.append(f"{len(points.lost)} inputs and outputs have no address, the first: {points.lost[0]}; add their points by hand")
    ports = (f"/dev/ttyS{number}" for number in range(99))
    channels = [channel(each, next(ports) if each.kind == "serial" else each.address) for each in parts.card.channels]
    doubts += [f"{each.name}: {port_words(each)}" for each in parts.card.channels if port_words(each)]
    text = [
        _head(parts),
        *channels,
        _CONTROLLER,
        *points.rows,
        _ROUTE,
        *([_ALTER] if parts.alters else []),
        _limited(parts.rest, parts.card),
    ]
    return "\n".join(text), doubts


def port_words(row: CardChannel) -> str:
    """Settings that only the machine shows."""
    if row.kind == "serial":
        return "name its port in address; /dev/ttyS0 and so on are assumed"
    return "" if row.with_port else "sio.cfx has no port for it; set port"


def _head(parts: Parts) -> str:
    settings = parts.card.settings
    language = "de" if settings.get("language", "").lower() in ("deutsch", "german") else "en"
    watchdog = settings.get("val3WatchdogPeriod", "-1")
    seconds = float(watchdog) if re.fullmatch(r"\d+(\.\d+)?", watchdog) else 0.0
    name = settings.get("robotName") or f"CS8 with {parts.application.rpartition('/')[2]}"
    comments = [f"# {key} = {value}" for key, value in settings.items() if key in _SHOWN or key.lower().startswith("userio")]
    lines = [
        f"# Written by `axisgate val3 import` from {parts.source}; arm {parts.card.arm or 'unknown'}.",
        "# The drives and the plant are those of a shipped cell: set them to the machine. Other settings of the card:",
        *comments,
        "format = 1\n\n[cell]",
        f"name     = {quoted(name)}",
        'replaces = "val3"',
        f"language = {quoted(language)}",
        'target   = "simulation"              # set to "machine" with drives',
        "\n[val3]",
        f"application = {quoted(parts.application)}",
        f"disk        = {quoted(parts.disk)}",
        'mode        = "remote"',
        f"system      = {quoted(parts.system)}",
        f"autostart   = {str(bool(parts.card.start)).lower()}",
        *([f"watchdog_s  = {seconds:g}"] if seconds > 0 else []),
        *_user_io(settings),
        "",
    ]
    return "\n".join(lines)


def _user_io(settings: Mapping[str, str]) -> list[str]:
    """[val3.user_io]: mode and ratio of the user boards, where the card has them."""
    found = {key.rpartition(".")[2].lower(): value for key, value in settings.items() if key.lower().startswith("userio")}
    if not found:
        return []
    mode = "noJitter" if found.get("mode", "").lower() == "nojitter" else "default"
    ratio = re.fullmatch(r"(\d+)(?:\.0*)?", found.get("cyclicratio", ""))
    return ["\n[val3.user_io]", f'mode  = "{mode}"', f"ratio = {min(max(int(ratio[1]), 1), 250) if ratio else -1}"]


_SHOWN = ("initWorkingMode", "monitorSpeed", "maxStartMonitorSpeed", "maxManuCartSpeed", "cpuExtPowerSupply", "serialNumber")
_CONTROLLER = '[controller]\nkind = "val3"\n'
_ALTER = (
    '[alter]   # alterBegin, alter and alterEnd of the application\nsource = "application"\ntype   = "REAL"\ninput  = 256\nstatus = 256\n'
)
_ROUTE = f'[[route]]   # the PLC starts and stops the application\nname = "run"\nfrom = "{RUN_BIT}"\nto   = "val3.run"\n'


def channel(row: CardChannel, address: str) -> str:
    """[[val3.channel]]."""
    lines = ["[[val3.channel]]", f"name    = {quoted(row.name)}", f"kind    = {quoted(row.kind)}", f"address = {quoted(address)}"]
    if row.kind == "serial":
        lines += [f"baud_rate = {row.baud_rate}", f"bits      = {row.bits}", f"parity    = {quoted(row.parity)}"]
        lines += [f"stop_bits = {row.stop_bits}", f"flow_control = {quoted(row.flow_control)}"]
    else:
        lines += [f"port    = {row.port}", *([f"clients = {row.clients}"] if row.kind == "server" else [])]
        lines += [f"nagle   = {str(row.nagle).lower()}"] if row.kind != "udp" else []
    lines += [f"end_of_string = {row.end_of_string}", f"timeout_s = {row.timeout_s:g}"]
    lines += [f"description = {quoted(row.description[:200])}"] if row.description else []
    return "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A TOML string."""
    return json.dumps(text, ensure_ascii=False)


def _limited(rest: str, card: Card) -> str:
    """Limits of the card where they are narrower; the emulated axis starts inside them."""
    axis = -1
    lines = []
    ranges: dict[str, tuple[float, float]] = {}
    name = ""
    for line in rest.splitlines():
        if line.startswith("[[axis]]"):
            axis += 1
        elif line.startswith("[plant.axis."):
            name = line.partition("[plant.axis.")[2].rstrip("]")
        if axis >= 0 and line.startswith("name"):
            name = line.split('"')[1]
        if line.startswith("limits") and (match := re.search(r"min = ([-\d.]+), max = ([-\d.]+)", line)):
            low = max(float(match[1]), card.lower.get(axis, -1e9))
            high = min(float(match[2]), card.upper.get(axis, 1e9))
            if low < high:
                line = line.replace(match[0], f"min = {low}, max = {high}")
                ranges[name] = (low, high)
        elif line.startswith("start") and name in ranges:
            low, high = ranges[name]
            given = float(line.partition("=")[2])
            if not low <= given <= high:
                line = f"start                = {(low + high) / 2}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def drives_of(cell: str) -> str:
    """Part of a shipped cell: from [rc_inputs] on, without its programs."""
    text = cell[cell.index("[rc_inputs]") :]
    while (at := text.find("[[program]]")) >= 0:
        behind = SECTION.search(text, at + 2)
        text = text[:at] + (text[behind.start() :] if behind else "")
    return text
