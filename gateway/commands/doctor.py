"""Check permissions and real-time settings of this machine; each finding has its remedy."""

import argparse
import dataclasses
import errno
import glob
import grp
import json
import os
import pathlib
import resource
import socket
import subprocess
from collections.abc import Iterable

from gateway.files.texts import spoken
from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.pure.reports.doctor import CanState, Finding, PortState, RealTime, can_interface, can_state, real_time, serial_port
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate doctor                                   every port and interface that is plugged in
  axisgate doctor --port /dev/ttyUSB0 --can can0    one port and one CAN interface, by name
  axisgate doctor --json                            the same as JSON
  axisgate doctor serial /dev/ttyUSB0               measured: echo of the adapter (loop plug), lateness of this machine
  axisgate doctor can socketcan:can0 --send         the same for a CAN adapter
  axisgate doctor --hour cell.toml                  for an hour: is this machine fast enough for the cycle of the cell?
exit code: 0 no finding, 1 something to improve, 2 command line or cell, 3 a named port or interface is missing"""
PORTS = ("/dev/serial/by-id/*", "/dev/ttyUSB*", "/dev/ttyACM*")
TRIED_PRIORITY = 10
IP_LIMIT_S = 5.0


def main(argv: list[str]) -> int:
    if argv[:1] in (["serial"], ["can"]):
        from gateway.tools.doctor.tools import main as measured  # its own options

        return measured(argv)
    parser = argparse.ArgumentParser(
        "axisgate doctor", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--port", action="append", default=[], metavar="DEVICE", help="a serial port; may be repeated")
    parser.add_argument("--can", action="append", default=[], metavar="IFACE", help="a CAN interface; may be repeated")
    parser.add_argument("--json", action="store_true", help="a list of JSON objects on standard output")
    parser.add_argument("--language", choices=LANGUAGES, help="language of the report (default: the system's)")
    parser.add_argument("--hour", metavar="CELL", help="measure for an hour how late this machine is, compared with the cycle of the cell")
    parser.add_argument("--seconds", type=float, default=3600.0, help="with --hour: seconds to measure instead of an hour")
    options = parser.parse_args(argv)
    if options.hour:
        return _hour(options)
    findings = [*real_time(read_real_time()), *ports(options.port), *buses(options.can)]
    if options.json:
        print(json.dumps([dataclasses.asdict(finding) for finding in findings], indent=1))
    else:
        language = language_of(options.language, dict(os.environ))
        print("\n".join(line for finding in findings for line in finding_lines(finding, language)))
    return verdict(findings)


def _hour(options: argparse.Namespace) -> int:
    from gateway.tools.cell_argument import load
    from gateway.tools.doctor.tools import hour

    cell = load(options.hour)
    if isinstance(cell, int):
        return cell
    if not 0 < options.seconds <= 86_400:
        complain("doctor", f"--seconds {options.seconds:g}: above 0, at most 86400 expected")
        return Exit.INVALID
    return hour(cell, options.seconds, language_of(options.language, dict(os.environ)), as_json=options.json)


def finding_lines(finding: Finding, language: str = "en") -> list[str]:
    """One finding as lines."""
    german = spoken("doctor").german
    level, what, text, todo, do = (
        german(each) if language == "de" else each for each in (finding.level, finding.what, finding.text, finding.todo, "do")
    )
    return [f"{level:<8} {what}: {text}"] + ([f"{'':<8} {do}: {todo}"] if todo else [])


def verdict(findings: Iterable[Finding]) -> Exit:
    """The worst finding decides."""
    levels = {finding.level for finding in findings}
    return Exit.ENVIRONMENT if "missing" in levels else Exit.FINDING if "warn" in levels else Exit.OK


def read_real_time() -> RealTime:
    """Limits, and whether FIFO is granted: tried on this process, then restored."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(TRIED_PRIORITY))
        os.sched_setscheduler(0, before[0], before[1])
        refused = ""
    except OSError as error:
        refused = os.strerror(error.errno or 0)
    throttle = pathlib.Path("/proc/sys/kernel/sched_rt_runtime_us")
    limit = int(throttle.read_text()) if throttle.is_file() else None
    memlock = -1 if os.geteuid() == 0 else resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]  # no limit binds root
    return RealTime(refused, resource.getrlimit(resource.RLIMIT_RTPRIO)[0], memlock, limit)


def ports(named: list[str]) -> list[Finding]:
    """The named ports, or every USB serial adapter once."""
    names = named or sorted({os.path.realpath(path): path for pattern in reversed(PORTS) for path in glob.glob(pattern)}.values())
    if not names:
        return [Finding("ports", "ok", "no USB serial adapter is plugged in; name others with --port /dev/ttyS0")]
    return [finding for name in names for finding in serial_port(read_port(name))]


def read_port(name: str) -> PortState:
    """What the system reports about a serial port."""
    path = pathlib.Path(name)
    if not path.exists():
        return PortState(name, False)
    try:
        group = grp.getgrgid(path.stat().st_gid).gr_name
        in_group = os.environ.get("USER", "") in grp.getgrnam(group).gr_mem
    except KeyError:
        group, in_group = str(path.stat().st_gid), False
    timer = pathlib.Path("/sys/class/tty", path.resolve().name, "device", "latency_timer")
    latency = int(timer.read_text()) if timer.is_file() else None
    return PortState(name, True, os.access(path, os.R_OK), os.access(path, os.W_OK), group, in_group, latency, str(timer))


def buses(named: list[str]) -> list[Finding]:
    """The named CAN interfaces, or all there are, or the reason there are none."""
    if why := no_can():
        level = "missing" if named else "ok"
        return [Finding("can", level, why, "broker:NAME is the local bus; a real one needs a kernel with CAN (modprobe can can-raw)")]
    states, why = read_links()
    if why:
        return [Finding("can", "missing" if named else "warn", why, "install iproute2")]
    if not named:
        found = [finding for state in states if state.kind in ("can", "vcan") for finding in can_interface(state)]
        return found or [Finding("can", "ok", "the kernel has CAN; there is no interface")]
    known = {state.name: state for state in states}
    absent = {name: [Finding(f"can {name}", "missing", "no such interface", "ip -brief link lists them")] for name in named}
    return [finding for name in named for finding in (can_interface(known[name]) if name in known else absent[name])]


def no_can() -> str:
    """Why this kernel cannot open a CAN socket; empty when it can."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        missing = error.errno in (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT)
        return "this kernel has no CAN" if missing else f"a CAN socket cannot be opened: {error.strerror}"
    return ""


def read_links() -> tuple[list[CanState], str]:
    """All interfaces, or why they cannot be listed."""
    try:
        done = subprocess.run(["ip", "-details", "-json", "link"], capture_output=True, text=True, timeout=IP_LIMIT_S, check=True)
        return [can_state(link) for link in json.loads(done.stdout)], ""
    except FileNotFoundError:
        return [], "the program ip is not installed"
    except (subprocess.SubprocessError, ValueError) as error:
        return [], f"ip -details -json link failed: {error}"
