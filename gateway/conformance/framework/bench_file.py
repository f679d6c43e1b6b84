"""The bench file (TOML): device, port, link, permitted writes, known facts, stimulus, power, report.  All faults in one run."""

import datetime
import pathlib
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import cast

from drivers.ports.open import tcp_address
from drivers.ports.serial.line_format import parse_format
from gateway.conformance.framework.bench_rules import error_faults, missing_files, near, rule_faults, wanted_in_pics
from protocols.p3964r.profiles import PROFILES

Table = Mapping[str, object]
Check = Callable[[object], str]  # "" or the expected form
STIMULI = ("operator", "periodic", "fetch", "modbus", "output", "command", "none")
RANGE = re.compile(r"^(\d+)(?:\.\.(\d+))?$")
DATA_WORD = re.compile(r"^DB\d{1,3}\.DW\d{1,3}$", re.IGNORECASE)
OBJECT = re.compile(r"^[0-9A-Fa-f]{4}:[0-9A-Fa-f]{1,2}$")
CELL = re.compile(r"^(input|holding|coil|discrete):\d{1,5}$")


class BadFile(Exception):
    """Faults of a file; each line names file, key, range and remedy."""

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


@dataclass(frozen=True, slots=True)
class Bench:
    """A checked bench file."""

    path: pathlib.Path | None
    url: str
    format: str = "9600 8E1"
    marks: bool | None = None
    device: Table = field(default_factory=dict)
    start: tuple[str, ...] = ()
    link: Table = field(default_factory=dict)
    touch: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    known: Mapping[str, bytes | int] = field(default_factory=dict)
    stimulus: Table = field(default_factory=dict)
    power: Table = field(default_factory=dict)
    report: Table = field(default_factory=dict)
    pics: Table = field(default_factory=dict)
    objects: frozenset[tuple[int, int]] = frozenset()  # of a CANopen device: may be written
    allowed: frozenset[str] = frozenset()  # motion, store, node: further permissions of [touch]

    @property
    def folder(self) -> pathlib.Path:
        """Paths of the file begin here."""
        return self.path.parent if self.path is not None else pathlib.Path.cwd()

    def named(self) -> list[str]:
        """Those that not every suite uses, as "link.unit"."""
        touched = [*self.touch, *sorted(self.allowed), *(["objects"] if self.objects else [])]
        known = sorted({"DB" if key.upper().startswith("DB") else key.partition(":")[0] for key in self.known})
        named = [f"link.{key}" for key in self.link] + [f"touch.{key}" for key in touched] + [f"known.{key}" for key in known]
        return [*named, *(["stimulus"] if self.stimulus else [])]


def _text(value: object) -> str:
    return "" if isinstance(value, str) and value else "a text"


def _url(value: object) -> str:
    if _text(value):
        return _text(value)
    wanted = "tcp://host:port with a port number 1 to 65535"
    return wanted if str(value).startswith("tcp://") and _address(value) else ""


def _format(value: object) -> str:
    try:
        parse_format(value if isinstance(value, str) else "")
    except ValueError as error:
        return str(error).partition('": ')[2].removesuffix(" expected").replace(" expected, e.g.", ", such as")
    return ""


def _flag(value: object) -> str:
    return "" if isinstance(value, bool) else "true or false"


def _argv(value: object) -> str:
    good = isinstance(value, list) and value and all(isinstance(one, str) for one in value)
    return "" if good else 'a list of texts such as ["python3", "station.py"]'


def _number(least: float, most: float) -> Check:
    def check(value: object) -> str:
        good = isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most
        return "" if good else f"a number {least:g} to {most:g}"

    return check


def _whole(least: int, most: int) -> Check:
    def check(value: object) -> str:
        good = isinstance(value, int) and not isinstance(value, bool) and least <= value <= most
        return "" if good else f"a whole number {least} to {most}"

    return check


def _one_of(*names: str) -> Check:
    return lambda value: "" if value in names else f"one of {', '.join(names)}"


def _line(value: object) -> str:
    good = isinstance(value, (str, int, float, datetime.date)) and not isinstance(value, bool)
    return "" if good else "a text, a number or a date"


def _address(value: object) -> str:
    wanted = 'an address such as "tcp://10.0.0.5:502"'
    try:
        return "" if isinstance(value, str) and value.startswith("tcp://") and tcp_address(value) else wanted
    except ValueError:
        return wanted


def _numbers(most: int) -> Check:
    def check(value: object) -> str:
        good = isinstance(value, list) and all(_span(one, most) for one in value)
        return "" if good else f'a list of numbers 0 to {most} or ranges such as "10..40"'

    return check


def _span(value: object, most: int) -> tuple[int, ...]:
    """The numbers of one entry; () where it is none."""
    if isinstance(value, int) and not isinstance(value, bool):
        return (value,) if 0 <= value <= most else ()
    found = RANGE.match(value.strip()) if isinstance(value, str) else None
    if found is None:
        return ()
    first, last = int(found[1]), int(found[2] or found[1])
    return tuple(range(first, last + 1)) if first <= last <= most else ()


def _objects(value: object) -> str:
    good = isinstance(value, list) and all(isinstance(one, str) and OBJECT.match(one) for one in value)
    return "" if good else 'a list of objects such as ["607A:0"], index and sub-index in hexadecimal'


TIMES: dict[str, tuple[str, ...]] = {  # field of the profile: names in a bench file
    "ack_delay": ("ack_delay_ms", "qvz_ms", "qvz", "adt_ms", "ack_delay"),
    "char_delay": ("char_delay_ms", "zvz_ms", "zvz", "cdt_ms", "char_delay"),
    "block_wait": ("block_wait_ms", "bwz_ms", "bwz", "block_wait"),
    "retry_pause": ("retry_pause_ms",),
    "no_buffer_wait": ("no_buffer_wait_ms",),
    "connect_attempts": ("connect_attempts",),
    "block_attempts": ("block_attempts",),
}
TIME_KEYS: dict[str, Check] = {name: _number(0, 3_600_000) for names in TIMES.values() for name in names} | {
    "connect_attempts": _whole(1, 255),
    "block_attempts": _whole(1, 255),
    "reaction_ms": _number(1, 3_600_000),
    "answer_ms": _number(1, 60_000),
}


def _times(value: object) -> str:
    return "" if isinstance(value, dict) else f"a table; keys: {', '.join(TIME_KEYS)}"


KEYS: dict[str, dict[str, Check]] = {
    "port": {"url": _url, "format": _format, "marks": _flag},
    "link": {
        "profile": _one_of(*PROFILES),
        "priority": _one_of("high", "low"),
        "times": _times,
        "layer": _one_of("rk512", "raw"),
        "block_check": _flag,
        "missing_db": _whole(0, 255),
        "db": _whole(0, 255),
        "words": _whole(1, 256),
        "reaction_ms": _number(1, 3_600_000),
        "answer_ms": _number(1, 60_000),
        "unit": _whole(0, 255),
        "missing_unit": _whole(0, 255),
        "node": _whole(1, 127),
        "module": _whole(1, 6),
        "eds": _text,
        "layout": _text,
        "cycle_ms": _number(1, 1000),
        "boot_ms": _number(1, 600_000),
        "speed": _whole(1, 0x7FFFFFFF),
        "way": _whole(1, 0x3FFFFFFF),
        "turn": _whole(1, 0x3FFFFFFF),
        "stop_ms": _number(1, 600_000),
    },
    "touch": {
        "db": _numbers(255),
        "holding": _numbers(65535),
        "coils": _numbers(65535),
        "objects": _objects,
        "motion": _flag,
        "store": _flag,
        "node": _flag,
    },
    "stimulus": {
        "kind": _one_of(*STIMULI),
        "prompt": _text,
        "timeout_ms": _number(1, 3_600_000),
        "period_ms": _number(1, 3_600_000),
        "command": _argv,
        "url": _address,
        "unit": _whole(0, 255),
        "coil": _whole(0, 65535),
        "holding": _whole(0, 65535),
        "value": _whole(0, 65535),
    },
    "power": {
        "on": _argv,
        "off": _argv,
        "command": _argv,
        "relay": _address,
        "coil": _whole(0, 65535),
        "unit": _whole(0, 255),
        "inverted": _flag,
        "prompt": _text,
        "limit_ms": _number(1, 3_600_000),
        "back_ms": _number(1, 3_600_000),
    },
    "report": dict.fromkeys("number place customer date method deviations uncertainty decision_rule person title laboratory".split(), _line)
    | {"language": _one_of("en", "de")},
}
FREE = ("device", "known", "pics")


def read_toml(path: pathlib.Path) -> dict[str, object]:
    """BadFile where it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise BadFile([f"{path}: cannot be read ({error.strerror or error}); check the path"]) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadFile([f"{path}: is not TOML ({error}); one key = value per line, texts in quotes"]) from error


def load_bench(path: pathlib.Path, items: Mapping[str, str] | None = None) -> Bench:
    """BadFile lists every fault.  items: of the PICS, key -> kind, where they are known."""
    found = read_toml(path)
    stated = found.get("pics")
    of_pics = pics_faults(stated, items) if items is not None and isinstance(stated, dict) else []
    faults = [f"{path}: {fault}" for fault in (*_faults(found), *of_pics, *missing_files(path.parent, found))]
    if faults:
        raise BadFile(faults)
    return _bench(path, found)


def _faults(found: Table) -> list[str]:
    faults = []
    for section, value in found.items():
        if section not in KEYS and section not in FREE:
            faults.append(f"[{section}]: no such table; there are {', '.join((*FREE, *KEYS))}{near(section, KEYS)}")
        elif not isinstance(value, dict):
            faults.append(f"{section}: a table [{section}] expected")
        else:
            faults += _section(section, value)
    port = found.get("port")
    if not isinstance(port, dict) or "url" not in port:
        faults.append('port.url: is missing; such as url = "/dev/ttyUSB0", "pty:/path", "tcp://host:port" or "machine:FILE.py:FACTORY"')
    return faults + rule_faults({name: value for name, value in found.items() if isinstance(value, dict)})


def _section(section: str, table: Table) -> list[str]:
    if section == "known":
        return [fault for key, value in table.items() if (fault := _known_fault(key, value))]
    if section in FREE:
        wanted = _argv(table["start"]) if section == "device" and "start" in table else ""
        return [f"device.start: {wanted} expected, found {table['start']!r}"] if wanted else []
    faults = _key_faults(section, table, KEYS[section])
    times = table.get("times")
    return faults + _key_faults("link.times", times, TIME_KEYS) if section == "link" and isinstance(times, dict) else faults


def _key_faults(section: str, table: Table, keys: Mapping[str, Check]) -> list[str]:
    faults = []
    for key, value in table.items():
        if key not in keys:
            faults.append(f"{section}.{key}: no such key; there are {', '.join(keys)}{near(key, keys)}")
        elif wanted := keys[key](value):
            faults.append(f"{section}.{key}: {wanted} expected, found {value!r}")
    return faults


def _known_fault(key: str, value: object) -> str:
    most = 255 if DATA_WORD.match(key) else 65535
    if any(int(number) > most for number in re.findall(r"\d+", key)):
        return f'known."{key}": numbers 0 to {most} expected'
    if DATA_WORD.match(key):
        good = isinstance(value, str) and re.fullmatch(r"(?:[0-9A-Fa-f]{2}\s*)+", value) is not None
        return "" if good else f'known."{key}": hexadecimal bytes such as "0A03" expected, found {value!r}'
    if CELL.match(key):
        most = 1 if key.startswith(("coil", "discrete")) else 65535
        good = isinstance(value, (int, bool)) and 0 <= value <= most
        return "" if good else f'known."{key}": a number 0 to {most} expected, found {value!r}'
    return f'known."{key}": a place such as "DB10.DW3", "input:7", "holding:7", "coil:7" or "discrete:7" expected'


def _bench(path: pathlib.Path, found: Table) -> Bench:
    def table(name: str) -> dict[str, object]:
        value = found.get(name, {})
        return dict(cast(dict[str, object], value))

    port, device = table("port"), table("device")
    start = device.pop("start", [])
    touched = table("touch")
    touch: dict[str, tuple[int, ...]] = {
        name: tuple(number for one in cast(list[object], touched[name]) for number in _span(one, 65535))
        for name in ("db", "holding", "coils")
        if name in touched
    }
    objects = [one.split(":") for one in cast(list[str], touched.get("objects", []))]
    known = {key: bytes.fromhex(value) if isinstance(value, str) else int(cast(int, value)) for key, value in table("known").items()}
    marks = port.get("marks")
    return Bench(
        path,
        str(port["url"]),
        str(port.get("format", "9600 8E1")),
        marks if isinstance(marks, bool) else None,
        device,
        tuple(cast(list[str], start)),
        table("link"),
        touch,
        known,
        table("stimulus"),
        table("power"),
        table("report"),
        table("pics"),
        frozenset((int(index, 16), int(sub, 16)) for index, sub in objects),
        frozenset(name for name in ("motion", "store", "node") if touched.get(name) is True),
    )


# ---- PICS and waivers
def load_pics(path: pathlib.Path, known: Mapping[str, str]) -> dict[str, object]:
    """`known`: key -> kind (bool, text, whole, table); a [pics] table or the keys at the top."""
    found = read_toml(path)
    table = found.get("pics", found)
    if not isinstance(table, dict):
        raise BadFile([f"{path}: pics: a table [pics] expected"])
    faults = pics_faults(table, known)
    if faults:
        raise BadFile([f"{path}: {fault}" for fault in faults])
    return dict(table)


def pics_faults(table: Table, known: Mapping[str, str]) -> list[str]:
    """Every unknown key and every value of the wrong kind."""
    faults = []
    for key, value in table.items():
        kind = known.get(key)
        if kind is None:
            faults.append(
                f"pics.{key}: no such item; there are {', '.join(known)}{near(key, known)}; axisgate conformance new-pics writes one"
            )
            continue
        if kind == "table" and isinstance(value, dict):
            faults += error_faults(value)
        elif wanted := wanted_in_pics(key, kind, value):
            faults.append(f"pics.{key}: {wanted} expected, found {value!r}")
    return faults


@dataclass(frozen=True, slots=True)
class Waiver:
    """A verdict that is accepted: by whom, why, until when."""

    id: str
    reason: str
    who: str
    until: str


def load_waivers(path: pathlib.Path, ids: frozenset[str], today: datetime.date) -> dict[str, Waiver]:
    """[[waiver]] id, reason, who, until; an expired one is a fault."""
    found = read_toml(path)
    faults, waivers = [], dict[str, Waiver]()
    rows = found.get("waiver", [])
    if not isinstance(rows, list) or set(found) - {"waiver"}:
        raise BadFile([f"{path}: only [[waiver]] tables with id, reason, who, until expected"])
    for number, row in enumerate(rows, 1):
        table = row if isinstance(row, dict) else {}
        said = _waiver_faults(table, ids, today)
        name = str(table.get("id", ""))
        if name in waivers:
            said.append(f"{name} is waived above already; remove one of them")
        faults += [f"{path}: waiver {number}: {fault}" for fault in said]
        if not said:
            waivers[name] = Waiver(name, str(table["reason"]), str(table["who"]), str(_date(table["until"])))
    if faults:
        raise BadFile(faults)
    return waivers


def _waiver_faults(row: Table, ids: frozenset[str], today: datetime.date) -> list[str]:
    """All that is wrong with one row."""
    keys = ("id", "reason", "who", "until")
    missing = [key for key in keys if not row.get(key)]
    faults = [f"{', '.join(missing)} missing; each needs id, reason, who, until"] if missing else []
    faults += [f"{key}: no such key; there are {', '.join(keys)}" for key in row if key not in keys]
    if row.get("id") and (name := str(row["id"])) not in ids:
        faults.append(f"id {name} is in no case of this suite{near(name, dict.fromkeys(ids))}")
    until = _date(row["until"]) if row.get("until") else today
    if until is None:
        faults.append(f"until {row['until']}: a date such as 2027-06-30 expected")
    elif until < today:
        faults.append(f"{row.get('id', 'it')} expired on {until}; renew it with a new date, or remove it")
    return faults


def _date(value: object) -> datetime.date | None:
    if isinstance(value, datetime.datetime):
        return value.date()
    if isinstance(value, datetime.date):
        return value
    try:
        return datetime.date.fromisoformat(str(value))
    except ValueError:
        return None
