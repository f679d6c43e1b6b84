"""Read or set one value of a running cell by any address: DB10.DW2, E 1.0, RC 7.3, K01_A_MN_RCI, 40001, axis.A1.actual."""

import argparse
import json
import socket
import time

from drivers.ports.base import runtime_dir
from gateway.tools.command_support import DONE, ENVIRONMENT, USAGE
from gateway.tools.runs import not_chosen
from gateway.tools.usage_language import complain

SUFFIX = "-services.sock"
EXAMPLES = """examples:
  axisgate var axis.A1.actual                   actual position of axis A1 in mm
  axisgate var DB10.DW2 --set 1200              as if the PLC had sent it (simulated cells only)
  axisgate var DB11.DW2 --watch                 until Ctrl-C
exit code: 0 shown or written, 2 no such name, or a value it does not take, 3 no such run"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate var", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("address", nargs="?", help="address or name; without one: all names")
    parser.add_argument("--set", dest="value", help="number to write (DW -32768..65535, bit 0 or 1)")
    parser.add_argument("--watch", action="store_true", help="print again whenever it changes")
    parser.add_argument("--name", help="name of the run, if several are active")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    up = runs_up()
    runs = [run for run in up if arguments.name in (None, run)]
    if len(runs) != 1:
        complain("var", not_chosen(arguments.name, up, "--name NAME"))
        return ENVIRONMENT
    request = {"op": "names"} if not arguments.address else {"op": "get", "address": arguments.address}
    if arguments.value is not None and arguments.address:
        request = {"op": "set", "address": arguments.address, "value": arguments.value}
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
            link.settimeout(2.0)
            link.connect(str(runtime_dir() / f"{runs[0]}{SUFFIX}"))
            return converse(link, request, watch=arguments.watch, as_json=arguments.json)
    except OSError as error:
        complain("var", f"run {runs[0]!r} does not answer ({error}); its services may be starting again")
        return ENVIRONMENT
    except KeyboardInterrupt:
        return DONE


def runs_up() -> list[str]:
    """Names of the runs whose services answer; a socket without a listener is left from a killed run."""
    found = []
    for path in sorted(runtime_dir().glob(f"*{SUFFIX}")):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            if probe.connect_ex(str(path)) == 0:
                found.append(path.name.removesuffix(SUFFIX))
    return found


def converse(link: socket.socket, request: dict[str, str], *, watch: bool, as_json: bool) -> int:
    """One question, or the same one ten times a second."""
    last = ""
    while True:
        link.sendall(json.dumps(request).encode() + b"\n")
        answer = json.loads(receive_line(link))
        if "error" in answer:
            complain("var", answer["error"])
            return USAGE
        shown = json.dumps(answer) if as_json else sentence(answer)
        if shown != last:
            print(shown, flush=True)
            last = shown
        if not watch:
            return DONE
        time.sleep(0.1)


def receive_line(link: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        part = link.recv(65536)
        if not part:
            raise ConnectionError("closed")
        data += part
    return data


def sentence(answer: dict[str, object]) -> str:
    """The answer as one line; names as a list."""
    names = answer.get("names")
    if isinstance(names, list):
        return "\n".join(map(str, names))
    columns = [f"{key} {value}" for key, value in answer.items() if key in ("KF", "DH", "KH", "KM", "KG", "REAL")]
    value = answer["value"]
    text = f"{value:.4f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
    quality = str(answer.get("quality", "GOOD"))
    columns += [] if quality == "GOOD" else [quality.lower()]  # an old value is marked old
    unit = str(answer.get("unit", "")).removeprefix("1 ")  # one count is one of it
    text += f"{' x' if unit[:1].isdigit() else ''} {unit}" if unit and isinstance(value, int | float) else ""  # 1200 x 0.1 mm
    return f"{answer['place']} = {text}" + (f"   ({', '.join(columns)})" if columns else "")
