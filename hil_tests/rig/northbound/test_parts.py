"""Parts of the northbound process by themselves: journald's protocol, the bound of the outbox, text of metrics, checks of the cell."""

import json
import math
import pathlib
import socket
import struct

import pytest

from gateway.cell_file.load import load_cell
from gateway.northbound.journald import Journald
from gateway.pure.cell.faults import CellFaults
from gateway.pure.reports.outbox import Outbox
from gateway.pure.reports.prometheus import Histogram, Page, labels, number
from hil_tests.lab.running.joined_running import cell_copy
from hil_tests.rig.northbound.test_northbound import parsed


def fields_of(datagram: bytes) -> dict[str, str]:
    """What journald reads: NAME=value, or NAME, length and value where it has line ends (its documentation, native protocol)."""
    found: dict[str, str] = {}
    while datagram:
        line, _, rest = datagram.partition(b"\n")
        name, equals, value = line.partition(b"=")
        if not equals:
            (length,) = struct.unpack("<Q", rest[:8])
            value, rest = rest[8 : 8 + length], rest[8 + length + 1 :]
        found[name.decode()] = value.decode()
        datagram = rest
    return found


def test_records_of_the_journal_reach_journald_whole_and_in_order(tmp_path: pathlib.Path) -> None:
    journal, address = tmp_path / "journal.jsonl", str(tmp_path / "socket")
    journal.write_text('{"kind": "old", "text": "of a run before"}\n')
    out = Journald(journal, "hall3", address)
    with journal.open("a") as file:
        file.write(json.dumps({"kind": "alarm", "process": "cycle", "text": "two\nlines", "ns": 5}) + "\n")
    out.look()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as journald:
        journald.settimeout(5)
        assert out.sent == 0, "nobody listens yet"
        journald.bind(address)
        with journal.open("a") as file:
            file.write('{"kind": "link", "text": "plc is back"}\nno json\n{"kind": "half')
        out.look()
        first, second = fields_of(journald.recv(65536)), fields_of(journald.recv(65536))
        assert first == {
            "MESSAGE": "two\nlines", "PRIORITY": "3", "SYSLOG_IDENTIFIER": "axisgate", "AXISGATE_RUN": "hall3",
            "AXISGATE_KIND": "alarm", "AXISGATE_PROCESS": "cycle", "AXISGATE_NS": "5",
        }  # fmt: skip
        assert (second["MESSAGE"], second["PRIORITY"]) == ("plc is back", "5")
        with journal.open("a") as file:
            file.write(' line", "text": "whole now"}\n')
        out.look()
        assert fields_of(journald.recv(65536))["MESSAGE"] == "whole now"
        journal.write_text('{"kind": "process", "text": "a new file"}\n')
        out.look()
        assert fields_of(journald.recv(65536))["MESSAGE"] == "a new file"
    out.close()


def test_the_outbox_is_bounded_and_drops_the_oldest_that_is_not_on_its_way() -> None:
    box = Outbox(keep=5, window=2)
    for n in range(1, 5):
        box.put(n, f"m{n}")
    assert [box.next(), box.next(), box.next()] == [(1, "m1"), (2, "m2"), None], "two on their way"
    for n in range(5, 9):
        box.put(n, f"m{n}")
    assert (len(box), box.dropped) == (5, 3), "3, 4 and 5 went; 1 and 2 are on their way"
    box.confirmed(1)
    box.confirmed(1)
    assert (box.next(), box.next(), len(box)) == ((6, "m6"), None, 4)
    box.confirmed(2)
    box.confirmed(6)
    assert [box.next(), box.next()] == [(7, "m7"), (8, "m8")]


def test_metrics_are_written_as_the_format_wants_them() -> None:
    page, seen = Page(), Histogram((0.001, 0.002))
    for value in (0.0005, 0.001, 0.0015, 7.0):
        seen.see(value)
    page.metric("a_total", "counter", "how many", [({"door": 'x"\\\ny'}, 3.0), ({"door": "z"}, 0.5)])
    page.metric("nothing", "gauge", "no samples", [])
    page.histogram("b_seconds", "how long", seen)
    assert page.text() == (
        '# HELP a_total how many\n# TYPE a_total counter\na_total{door="x\\"\\\\\\ny"} 3\na_total{door="z"} 0.5\n'
        "# HELP b_seconds how long\n# TYPE b_seconds histogram\n"
        'b_seconds_bucket{le="0.001"} 2\nb_seconds_bucket{le="0.002"} 3\nb_seconds_bucket{le="+Inf"} 4\n'
        "b_seconds_sum 7.003\nb_seconds_count 4\n"
    )
    assert len(parsed(page.text())) == 7
    assert [number(value) for value in (math.inf, -math.inf, math.nan, 1e16, 2.0)] == ["+Inf", "-Inf", "NaN", "1e+16", "2"]
    assert labels({}) == ""


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ('[northbound.mqtt]\nbroker = "10.0.0.7:1883"', "northbound.mqtt.broker"),
        ('[northbound.mqtt]\npassword_file = "none"', "northbound.mqtt.password_file"),
        ('[northbound.opcua]\nbind = "0.0.0.0:4840"', "northbound.opcua.bind"),
        ('[northbound.metrics]\nbind = "0.0.0.0:9480"', "northbound.metrics.bind"),
        ('[northbound.metrics]\nbind = "127.0.0.1:99999"', "northbound.metrics.bind"),
        ("[northbound]\nperiod_ms = 200", "northbound"),
    ],
)
def test_check_refuses_what_would_leave_the_computer_in_the_open(tmp_path: pathlib.Path, table: str, key: str) -> None:
    with pytest.raises(CellFaults) as refused:
        load_cell(str(cell_copy("host-telegrams", tmp_path, more=table)))
    assert [fault.key for fault in refused.value.faults] == [key]


def test_what_is_meant_is_taken(tmp_path: pathlib.Path) -> None:
    (tmp_path / "ca.pem").write_text("a certificate")
    table = '[northbound.mqtt]\nbroker = "10.0.0.7:8883"\ntls_ca = "ca.pem"\n[northbound.metrics]\nbind = "0.0.0.0:9480"\nopen = true'
    north = load_cell(str(cell_copy("host-telegrams", tmp_path, more=table))).northbound
    assert north is not None and north.mqtt is not None and north.metrics is not None and north.opcua is None
    assert (north.mqtt.tls_ca, north.metrics.open, north.period_ms) == ("ca.pem", True, 1000)
