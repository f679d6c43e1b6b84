"""What doctor says about ports, real time and CAN interfaces, without any of them."""

from gateway.pure.reports.doctor import CanState, Finding, PortState, RealTime, can_interface, can_state, real_time, serial_port


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
