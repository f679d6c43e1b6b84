"""What doctor says about ports, real time and CAN interfaces, without any of them."""

import re
from collections.abc import Iterator
from itertools import product

import pytest

from gateway.commands import doctor
from gateway.pure.reports.doctor import CanState, Finding, PortState, RealTime, can_interface, can_state, real_time, serial_port
from gateway.pure.reports.latency import Measured
from gateway.tools.doctor.tools import lines

ENGLISH = re.compile(r"\b(a|and|are|be|by|could|does|failed|for|group|has|installed|is|it|no|not|of|only|set|the|this|up|with|would)\b")
TYPED = re.compile(r"sudo .*|echo 1 .*|rtprio \d+|ip -\w+( -\w+)* link|by-id|(--)?port")  # what is typed has no language


def levels(findings: list[Finding]) -> list[str]:
    return [finding.level for finding in findings]


def test_a_port_without_permission_names_the_group_command() -> None:
    (finding,) = serial_port(PortState("/dev/ttyUSB0", True, False, False, "dialout"))
    assert finding.level == "warn" and finding.todo == "sudo usermod -aG dialout $USER"
    (finding,) = serial_port(PortState("/dev/ttyUSB0", True, True, False, "dialout", in_group=True))
    assert "log out" in finding.todo


def test_the_latency_timer_is_reported_with_the_command_that_sets_it() -> None:
    port = PortState("/dev/ttyUSB0", True, True, True, "dialout", True, 16, "/sys/class/tty/ttyUSB0/device/latency_timer")
    findings = serial_port(port)
    assert levels(findings) == ["ok", "warn"]
    assert "16 ms" in findings[1].text
    assert findings[1].todo == "echo 1 | sudo tee /sys/class/tty/ttyUSB0/device/latency_timer"


def test_a_missing_port_is_missing() -> None:
    assert levels(serial_port(PortState("/dev/ttyUSB9", False))) == ["missing"]


def test_real_time() -> None:
    assert levels(real_time(RealTime("", 40, -1, 950000))) == ["ok", "ok", "ok"]
    refused = real_time(RealTime("Operation not permitted", 0, 8 << 20, None))
    assert levels(refused) == ["warn", "warn"] and "limits.d" in refused[0].todo and "8 MiB" in refused[1].text


LINK = {
    "ifname": "can0",
    "flags": ["NOARP", "UP", "LOWER_UP", "ECHO"],
    "txqlen": 10,
    "linkinfo": {
        "info_kind": "can",
        "info_data": {"state": "ERROR-PASSIVE", "restart_ms": 100, "bittiming": {"bitrate": 500000, "sample_point": "0.875"}},
    },
}


def test_an_interface_out_of_ip_json() -> None:
    state = can_state(LINK)
    assert state == CanState("can0", True, "can", 500000, 100, "ERROR-PASSIVE", 10)
    said = can_interface(state)
    assert levels(said) == ["ok", "warn", "warn", "warn", "warn"]
    assert ["1 Mbit/s" in said[1].text, "restart-ms 100" in said[2].text, "120 ohm" in said[3].todo, "txqueuelen" in said[4].todo] == [
        True
    ] * 4


def test_other_interfaces() -> None:
    assert levels(can_interface(CanState("vcan0", True, "vcan"))) == ["ok"]
    assert levels(can_interface(CanState("vcan0", False, "vcan"))) == ["warn"]
    assert levels(can_interface(CanState("eth0", True, ""))) == ["missing"]
    assert levels(can_interface(can_state({"ifname": "can0", "linkinfo": {"info_kind": "can"}}))) == ["warn", "warn"]


def findings(monkeypatch: pytest.MonkeyPatch) -> Iterator[Finding]:
    """All that doctor reports."""
    for exists, usable, member, latency in product((False, True), (False, True), (False, True), (None, 1, 16)):
        yield from serial_port(PortState("/dev/ttyUSB0", exists, usable, usable, "dialout", member, latency, "/sys/timer"))
    for refused, locked in product(("", "Operation not permitted"), (-1, 8 << 20)):
        yield from real_time(RealTime(refused, 40, locked, 950000))
    for up, kind, rate, state in product((False, True), ("can", "vcan", "tun", ""), (None, 500000), ("", "BUS-OFF")):
        yield from can_interface(CanState("can0", up, kind, rate, 100, state, 10))
    monkeypatch.setattr(doctor, "PORTS", ())
    yield from doctor.ports([])
    found: tuple[list[CanState], str]
    for found in (([], ""), ([], "the program ip is not installed"), ([], "ip -details -json link failed: 1")):
        monkeypatch.setattr(doctor, "no_can", lambda: "")
        monkeypatch.setattr(doctor, "read_links", lambda found=found: found)
        yield from [*doctor.buses([]), *doctor.buses(["can7"])]
    for why in ("this kernel has no CAN", "a CAN socket cannot be opened: Operation not permitted"):
        monkeypatch.setattr(doctor, "no_can", lambda why=why: why)
        yield from doctor.buses([])


def test_all_that_doctor_reports_has_its_german(monkeypatch: pytest.MonkeyPatch) -> None:
    said = {line for finding in findings(monkeypatch) for line in doctor.finding_lines(finding, "de")}
    late, quick = Measured("scheduling of this machine", [17.0], 0.25), Measured("adapter echo", [0.5])
    said |= {line for measured in ([late], [quick], [late, quick]) for line in lines(measured, 2, "de")}
    assert len(said) > 40
    assert [line for line in sorted(said) if ENGLISH.search(TYPED.sub("", line))] == []
