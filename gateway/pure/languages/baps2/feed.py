"""What a dry run is given from outside: times, inputs, device data, points, files.  Checked here; each fault is one sentence."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.baps2.standard import DEVICES

SECOND = 1_000_000_000
KEYS = ("block_s", "p5_ms", "until_s", "belts", "compiled", "start", "points", "input", "devices", "files")

INPUT_KEYS = ("channel", "value", "at")


class FeedFault(Exception):
    """The feed is faulty: one sentence."""


@dataclass(frozen=True, slots=True)
class UnitFeed:
    """A device: its protocol (1..8) and its received data: (moment, bytes)."""

    protocol: int = 5
    incoming: tuple[tuple[int, bytes], ...] = ()


@dataclass(slots=True)
class Feed:
    """All times in nanoseconds."""

    block: int = SECOND
    p5: int = 10_000_000
    until: int = 20 * SECOND
    belts: dict[int, float] = field(default_factory=lambda: dict.fromkeys(range(1, 9), 0.0))  # number -> mm/s
    compiled: tuple[str, ...] = ()
    start: dict[str, tuple[float, ...]] = field(default_factory=dict)
    points: dict[str, dict[str, tuple[float, ...]]] = field(default_factory=dict)
    inputs: dict[int, list[tuple[int, float]]] = field(default_factory=dict)  # channel -> (moment, value), rising
    units: dict[str, UnitFeed] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)


def feed_of(raw: Mapping[str, object]) -> Feed:
    """Return the feed from the tables of a TOML file.  Raise FeedFault with the fault, its place, and the expected form."""
    _known(raw, KEYS, "a feed")
    feed = Feed()
    feed.block = _seconds(raw, "block_s", 1.0)
    feed.p5 = round(_number(raw.get("p5_ms", 10), "p5_ms", 1, 1_000) * 1e6)
    feed.until = _seconds(raw, "until_s", 20.0)
    feed.belts = _belts(raw.get("belts", 8))
    feed.compiled = tuple(_program(name) for name in _list(raw.get("compiled", []), "compiled"))
    feed.start = {name.upper(): _point(value, f"start.{name}") for name, value in _table(raw.get("start", {}), "start").items()}
    feed.points = {
        program.upper(): {
            name.upper(): _point(value, f"points.{program}.{name}") for name, value in _table(points, f"points.{program}").items()
        }
        for program, points in _table(raw.get("points", {}), "points").items()
    }
    for each in _list(raw.get("input", []), "input"):
        _input(_table(each, "input"), feed.inputs)
    for moments in feed.inputs.values():
        moments.sort(key=lambda moment: moment[0])
    feed.units = {
        name.upper(): _unit(name, _table(value, f"devices.{name}")) for name, value in _table(raw.get("devices", {}), "devices").items()
    }
    feed.files = {name.upper(): _hex(value, f"files.{name}") for name, value in _table(raw.get("files", {}), "files").items()}
    return feed


def _known(table: Mapping[str, object], keys: tuple[str, ...], what: str) -> None:
    """A key that is misspelt would be without effect."""
    for key in table:
        if key not in keys:
            raise FeedFault(f"{key} is not a key of {what}; the keys are {', '.join(keys)}")


def _program(name: object) -> str:
    if not isinstance(name, str):
        raise FeedFault(f"compiled: {name!r} is not a name of a program")
    return name.upper().removesuffix(".QLL")


def _seconds(raw: Mapping[str, object], key: str, default: float) -> int:
    return round(_number(raw.get(key, default), key, 0.001, 86_400) * SECOND)


def _number(value: object, where: str, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise FeedFault(f"{where} = {value!r}: a number from {low:g} to {high:g} is expected")
    return float(value)


def _table(value: object, where: str) -> Mapping[str, object]:
    if not isinstance(value, Mapping):
        raise FeedFault(f"{where} is not a table")
    return value


def _list(value: object, where: str) -> list[object]:
    if not isinstance(value, list):
        raise FeedFault(f"{where} is not a list")
    return value


def _point(value: object, where: str) -> tuple[float, ...]:
    found = tuple(_number(each, where, -1e12, 1e12) for each in (value if isinstance(value, list) else [value]))
    if not 1 <= len(found) <= 24:
        raise FeedFault(f"{where} has {len(found)} components; 1 to 24 are expected")
    return found


def _belts(value: object) -> dict[int, float]:
    """Read a number of belts at rest, a list of speeds in mm/s, or a table: channel or number -> mm/s."""
    if isinstance(value, int) and not isinstance(value, bool):
        return dict.fromkeys(range(1, int(_number(value, "belts", 0, 8)) + 1), 0.0)
    if isinstance(value, list):
        value = {str(number): speed for number, speed in enumerate(value, 1)}
    found = {}
    for name, speed in _table(value, "belts").items():
        number = int(name) % 500 if name.isascii() and name.isdecimal() and len(name) <= 3 else 0
        if not 1 <= number <= 8:
            raise FeedFault(f"belts.{name}: a belt has the number 1..8 or the channel 501..508")
        found[number] = _number(speed, f"belts.{name}", -1e6, 1e6)
    return found


def _input(table: Mapping[str, object], inputs: dict[int, list[tuple[int, float]]]) -> None:
    _known(table, INPUT_KEYS, "an input")
    if "channel" not in table:
        raise FeedFault("an input without channel")
    channel = int(_number(table["channel"], "input.channel", 1, 1_999)) % 1_000
    value = table.get("value", 1)
    number = float(value) if isinstance(value, bool) else _number(value, f"input {channel} value", -3.4e38, 3.4e38)
    inputs.setdefault(channel, []).append((round(_number(table.get("at", 0), f"input {channel} at", 0, 86_400) * SECOND), number))


def _unit(name: str, table: Mapping[str, object]) -> UnitFeed:
    if name.upper() not in DEVICES:
        raise FeedFault(f"devices.{name}: the devices are {', '.join(sorted(DEVICES))}")
    _known(table, ("protocol", "in"), f"devices.{name}")
    incoming = []
    for each in _list(table.get("in", []), f"devices.{name}.in"):
        row = _table(each, f"devices.{name}.in")
        _known(row, ("hex", "at"), f"devices.{name}.in")
        at = round(_number(row.get("at", 0), f"devices.{name}.in at", 0, 86_400) * SECOND)
        incoming.append((at, _hex(row.get("hex"), f"devices.{name}.in hex")))
    protocol = int(_number(table.get("protocol", 5), f"devices.{name}.protocol", 1, 8))
    return UnitFeed(protocol, tuple(sorted(incoming, key=lambda row: row[0])))


def _hex(value: object, where: str) -> bytes:
    try:
        return bytes.fromhex(str(value))
    except ValueError:
        raise FeedFault(f"{where} = {value!r}: pairs of hexadecimal digits are expected") from None
