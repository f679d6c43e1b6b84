"""Findings of `axisgate doctor` from what was read of the system; pure, so that they are tested without hardware."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

DIALOUT = "dialout"
LATENCY_GOOD_MS = 1


@dataclass(frozen=True, slots=True)
class Finding:
    """One line: subject, level (ok, warn, or missing for a named thing that does not exist), text, and what to do."""

    what: str
    level: str
    text: str
    todo: str = ""


@dataclass(frozen=True, slots=True)
class PortState:
    """What the system reports about one serial port; latency_ms is None if the driver has no such timer."""

    name: str
    exists: bool
    readable: bool = False
    writable: bool = False
    group: str = ""
    in_group: bool = False
    latency_ms: int | None = None
    latency_file: str = ""


@dataclass(frozen=True, slots=True)
class RealTime:
    """Limits of this user and what happened when FIFO was tried; memlock_bytes -1 is unlimited."""

    fifo_error: str
    rtprio: int
    memlock_bytes: int
    rt_runtime_us: int | None


@dataclass(frozen=True, slots=True)
class CanState:
    """The settings of one interface, from `ip -details -json link`."""

    name: str
    up: bool
    kind: str
    bitrate: int | None = None
    restart_ms: int | None = None
    state: str = ""
    txqlen: int | None = None


def serial_port(port: PortState) -> list[Finding]:
    """Permissions and latency timer of one port."""
    what = f"port {port.name}"
    if not port.exists:
        return [Finding(what, "missing", "does not exist", "plug the adapter in; ls /dev/serial/by-id/ shows what is there")]
    if not (port.readable and port.writable):
        member = (
            "log out and in again: the group takes effect at the next login"
            if port.in_group
            else f"sudo usermod -aG {port.group or DIALOUT} $USER"
        )
        return [Finding(what, "warn", f"no permission to read and write (group {port.group or '?'})", member)]
    findings = [Finding(what, "ok", "can be read and written")]
    if port.latency_ms is not None:
        late = port.latency_ms > LATENCY_GOOD_MS
        todo = f"echo {LATENCY_GOOD_MS} | sudo tee {port.latency_file}" if late else ""
        text = f"latency timer {port.latency_ms} ms" + (": every answer waits up to this long in the adapter" if late else "")
        findings.append(Finding(what, "warn" if late else "ok", text, todo))
    return findings


def real_time(state: RealTime) -> list[Finding]:
    """May the cycle run with FIFO priority and locked memory?"""
    limits = "write '* - rtprio 40' and '* - memlock unlimited' to /etc/security/limits.d/axisgate.conf, then log in again"
    findings = []
    if state.fifo_error:
        text = f"SCHED_FIFO refused ({state.fifo_error}; rtprio limit {state.rtprio}): the demo and run --sim use P5 = 10 ms"
        findings.append(Finding("real time", "warn", text, limits))
    else:
        findings.append(Finding("real time", "ok", f"SCHED_FIFO allowed (rtprio limit {state.rtprio})"))
    locked = state.memlock_bytes < 0 or state.memlock_bytes >= 256 << 20
    amount = "unlimited" if state.memlock_bytes < 0 else f"{state.memlock_bytes >> 20} MiB"
    findings.append(Finding("memory lock", "ok" if locked else "warn", f"limit {amount}", "" if locked else limits))
    if state.rt_runtime_us is not None and state.rt_runtime_us >= 0:
        findings.append(
            Finding("RT throttling", "ok", f"real-time tasks get {state.rt_runtime_us} us of each period (kernel.sched_rt_runtime_us)")
        )
    return findings


def can_interface(can: CanState) -> list[Finding]:
    """Bit rate, restart rule, state and queue of one CAN interface (users.md 3.3)."""
    what = f"can {can.name}"
    if can.kind == "vcan":
        todo = "" if can.up else f"sudo ip link set {can.name} up"
        return [Finding(what, "ok" if can.up else "warn", f"vcan, {'up' if can.up else 'down'}: no bit rate, no errors, no limit", todo)]
    if can.kind != "can":
        return [Finding(what, "missing", f"is not a CAN interface (kind {can.kind or 'unknown'})", "ip -details link shows which are")]
    link = f"sudo ip link set {can.name}"
    set_up = f"{link} down; {link} type can bitrate 1000000 restart-ms 0; {link} up"
    findings = [Finding(what, "ok" if can.up else "warn", "up" if can.up else "down", "" if can.up else set_up)]
    if can.bitrate != 1_000_000:
        text = f"bit rate {can.bitrate}: drives communicate at 1 Mbit/s" if can.bitrate else "no bit rate set"
        findings.append(Finding(what, "warn", text, set_up))
    if can.restart_ms:
        text = f"restart-ms {can.restart_ms}: the kernel would also recover from bus-off by itself; axisgate does it"
        findings.append(Finding(what, "warn", text, set_up))
    if can.state in ("BUS-OFF", "ERROR-PASSIVE", "ERROR-WARNING"):
        findings.append(
            Finding(
                what, "warn", f"state {can.state}", "check termination (120 ohm at both ends), bit rate and that another node acknowledges"
            )
        )
    if can.txqlen is not None and can.txqlen < 32:
        findings.append(Finding(what, "warn", f"transmit queue {can.txqlen}", f"sudo ip link set {can.name} txqueuelen 128"))
    return findings


def can_state(link: Mapping[str, object]) -> CanState:
    """One element of `ip -details -json link`."""
    info = _table(link.get("linkinfo"))
    data = _table(info.get("info_data"))
    timing = _table(data.get("bittiming"))
    flags = link.get("flags")
    up = isinstance(flags, Sequence) and "UP" in flags
    return CanState(
        str(link.get("ifname", "?")), up, str(info.get("info_kind", "")), _int(timing.get("bitrate")),
        _int(data.get("restart_ms")), str(data.get("state", "")), _int(link.get("txqlen")),
    )  # fmt: skip


def _table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _int(value: object) -> int | None:
    return value if isinstance(value, int) else None
