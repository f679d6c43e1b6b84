"""Active runs of this computer, from the supervisors' own sockets: they answer also while the services are down."""

import contextlib
import json
import time

from drivers.ports.base import PortError, runtime_dir
from gateway.runtime.supervisor_client import ask
from gateway.tools.usage_language import complain

ASK_S = 2.0
SERVICES = "-services"
START = "axisgate run CELL --sim"
Row = dict[str, object]


def asked(run: str, op: str, **more: str) -> Row:
    """The supervisor's answer.  PortError: no such run, or it does not answer."""
    try:
        with ask(run, op, ASK_S, **more) as connection:
            found = json.loads(connection.makefile().readline())
    except PortError:
        raise
    except (OSError, ValueError) as error:
        raise PortError(f"run {run!r} does not answer ({error})") from error
    return found if isinstance(found, dict) else {}


def runs() -> dict[str, Row]:
    """Name -> status of every run, without the remains of killed ones."""
    found = {}
    for path in sorted(runtime_dir().glob("*.sock")):
        if not path.stem.endswith(SERVICES):
            with contextlib.suppress(PortError):
                status = asked(path.stem, "status")
                if "processes" in status:
                    found[path.stem] = status
    return found


def chosen(command: str, name: str | None) -> str | None:
    """The run a command means; None after reporting that there is not exactly one."""
    up = list(runs())
    if name in up:
        return name
    if name is None and len(up) == 1:
        return up[0]
    complain(command, not_chosen(name, up, f"axisgate {command} {up[0]}" if up else ""))
    return None


def not_chosen(name: str | None, up: list[str], choose: str) -> str:
    """Why that name, or none, does not select one of these active runs, and what to type: `choose` if there are several."""
    if not up:
        return f"no run is active; start one with: {START}"
    return f"{f'no run {name!r} is active' if name else 'several runs are active'}; active: {', '.join(up)}; choose one: {choose}"


def processes(status: Row) -> list[Row]:
    """Its rows, one for each process."""
    rows = status.get("processes")
    return [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []


def alarms(status: Row) -> list[str]:
    """Sentences of the active alarms."""
    words = status.get("alarms")
    return [str(each) for each in words] if isinstance(words, list) else []


def ended(run: str, within_s: float) -> bool:
    """Whether that run has ended within so many seconds."""
    until = time.monotonic() + within_s
    while time.monotonic() < until:
        try:
            asked(run, "status")
        except PortError:
            if not (runtime_dir() / f"{run}.sock").exists():
                return True
        time.sleep(0.05)
    return False
