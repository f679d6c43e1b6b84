"""URL of a CAN adapter that python-can drives: INTERFACE:CHANNEL[@BITRATE][?OPTION=VALUE&...].

Options are python-can's own for that interface, e.g. `socketcand:can0?host=10.0.0.5&port=29536`,
`slcan:/dev/ttyACM0@500000?sleep_after_open=2`.
"""

import re
from dataclasses import dataclass, field

from drivers.ports.base import PortError

OURS = ("broker", "socketcan", "cycle", "memory")  # not through python-can, or no adapters
EXAMPLES = "slcan:/dev/ttyACM0@1000000, pcan:PCAN_USBBUS1, kvaser:0, socketcand:can0?host=10.0.0.5&port=29536"
URL = re.compile(r"^(?P<interface>[a-z][a-z0-9_-]*):(?P<channel>[^@?]+)(@(?P<bitrate>\d+))?(\?(?P<options>[^?]+))?$")
Option = str | int | float | bool
AS_WRITTEN = ("channel", "serial", "device", "host")  # never a number


@dataclass(frozen=True, slots=True)
class Adapter:
    """Arguments for python-can."""

    interface: str
    channel: str
    bitrate: int | None = None  # bit/s
    options: dict[str, Option] = field(default_factory=dict)


def is_adapter(url: str) -> bool:
    """True for a port that belongs neither to the kernel nor to the local bus, and looks like an adapter."""
    found = URL.match(url)
    return found is not None and found["interface"] not in OURS


def adapter_of(url: str) -> Adapter:
    """PortError with the form when it is none."""
    found = URL.match(url)
    if found is None:
        raise PortError(f"{url!r}: an adapter is INTERFACE:CHANNEL[@BITRATE][?OPTION=VALUE&...], e.g. {EXAMPLES}")
    options: dict[str, Option] = {}
    for part in (found["options"] or "").split("&") if found["options"] else ():
        key, equals, value = part.partition("=")
        if not (key and equals and value):
            raise PortError(f"{url!r}: option {part!r}: an option is NAME=VALUE as python-can names it")
        options[key] = value if key in AS_WRITTEN else _value(value)
    return Adapter(found["interface"], found["channel"], int(found["bitrate"]) if found["bitrate"] else None, options)


def _value(text: str) -> Option:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
