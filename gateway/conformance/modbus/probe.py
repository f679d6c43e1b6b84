"""Sends raw requests to a Modbus TCP server and reports the answers; and finds a value in its registers."""

import contextlib
import html
import socket
import struct
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.ports.base import PortError
from protocols.modbus.finding import Place, find
from protocols.modbus.mbap import HEADER
from protocols.modbus.probing import Case, Heard, Said, Verdict, frame, judge, split

Report = dict[str, object]
CONNECT_S = 3.0
TABLES = {"holding": 3, "input": 4}
AT_ONCE = 100  # registers of one read


@dataclass(frozen=True, slots=True)
class Result:
    """One case played."""

    case: Case
    heard: Heard
    verdict: Verdict
    why: str


class Prober:
    """Plays each case on a connection of its own, so that none depends on the one before."""

    def __init__(self, host: str, port: int, wait_s: float = 1.0) -> None:
        self.host, self.port, self.wait_s = host, port, wait_s

    def connect(self) -> socket.socket:
        """PortError names address and port."""
        try:
            connection = socket.create_connection((self.host, self.port), timeout=CONNECT_S)
        except OSError as error:
            raise PortError(f"Modbus server {self.host}:{self.port}: no connection ({error}); check address, port and network") from error
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def play(self, case: Case) -> Result:
        """Send the pieces, then receive until all answers are complete, the server closes, or the wait is over."""
        with self.connect() as connection:
            with contextlib.suppress(ConnectionError):  # it may close before all of it was sent
                for piece in case.pieces:
                    connection.sendall(piece)
                    time.sleep(case.apart_ms / 1000)
            heard = self._hear(connection, case.answers)
        verdict, why = judge(case, heard)
        return Result(case, heard, verdict, why)

    def _hear(self, connection: socket.socket, due: int) -> Heard:
        data, said, rest = b"", list[Said](), b""
        end = time.monotonic() + self.wait_s
        while len(said) < due and (left := end - time.monotonic()) > 0:
            connection.settimeout(left)
            try:
                more = connection.recv(4096)
            except TimeoutError:
                break
            except ConnectionError:
                more = b""
            if not more:
                return Heard(tuple(said), True, rest)
            data += more
            said, rest = split(data)
        return Heard(tuple(said), False, rest)

    def registers(self, unit: int, first: int, last: int) -> dict[str, dict[int, int]]:
        """The readable registers of both tables."""
        found: dict[str, dict[int, int]] = {table: {} for table in TABLES}
        with self.connect() as connection:
            connection.settimeout(max(self.wait_s, 2.0))
            for table, function in TABLES.items():
                for at in range(first, last + 1, AT_ONCE):
                    found[table] |= self._block(connection, unit, function, at, min(AT_ONCE, last + 1 - at))
        return found

    def _block(self, connection: socket.socket, unit: int, function: int, at: int, count: int) -> dict[int, int]:
        """A block that is refused is read in halves, down to single registers."""
        words = self._read(connection, unit, function, at, count)
        if words is not None:
            return dict(enumerate(words, at))
        if count == 1:
            return {}
        half = count // 2
        return self._block(connection, unit, function, at, half) | self._block(connection, unit, function, at + half, count - half)

    def _read(self, connection: socket.socket, unit: int, function: int, at: int, count: int) -> tuple[int, ...] | None:
        try:
            connection.sendall(frame(struct.pack(">BHH", function, at, count), unit))
            head = _exactly(connection, HEADER.size)
            body = _exactly(connection, HEADER.unpack(head)[2])
        except OSError as error:
            raise PortError(f"Modbus server {self.host}:{self.port}: ends reading ({error})") from error
        if len(body) != 3 + 2 * count or body[1] != function:
            return None
        return struct.unpack(f">{count}H", body[3:])


def _exactly(connection: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise ConnectionError("closed by the server")
        data += more
    return data


def probe(prober: Prober, cases: Sequence[Case], on_result: Callable[[Result], None]) -> list[Result]:
    """All cases, each reported as soon as it is judged."""
    results = []
    for case in cases:
        result = prober.play(case)
        on_result(result)
        results.append(result)
    return results


def as_report(prober: Prober, unit: int, results: Sequence[Result]) -> Report:
    """For JSON and HTML."""
    counts = Counter(result.verdict.value for result in results)
    return {
        "server": f"{prober.host}:{prober.port}",
        "unit": unit,
        "counts": {verdict.value: counts.get(verdict.value, 0) for verdict in Verdict},
        "cases": [
            {
                "name": result.case.name,
                "section": result.case.section,
                "sent": b"".join(result.case.pieces).hex(" ").upper(),
                "heard": result.heard.words(),
                "verdict": result.verdict.value,
                "why": result.why,
            }
            for result in results
        ],
    }


def summary(report: Report) -> str:
    """ "40 PASS, 2 WARN, .." """
    counts = report["counts"]
    assert isinstance(counts, dict)
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items())


def to_html(report: Report) -> str:
    """One page that prints."""
    cases = report["cases"]
    assert isinstance(cases, list)
    colours = {"PASS": "#dfd", "WARN": "#ffd", "FAIL": "#fdd"}
    rows = "".join(
        f'<tr style="background:{colours.get(case["verdict"], "#fff")}">'
        + "".join(f"<td>{html.escape(_short(str(case[key])))}</td>" for key in ("verdict", "name", "section", "sent", "heard", "why"))
        + "</tr>\n"
        for case in cases
    )
    result_text = summary(report)
    return (
        '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>Modbus probe</title>'
        "<style>body{font:14px sans-serif}td,th{border:1px solid #999;padding:2px 6px;text-align:left;font-size:12px}"
        "table{border-collapse:collapse}</style>"
        f"<h1>Modbus probe of {html.escape(str(report['server']))}, unit {report['unit']}</h1><p>{html.escape(result_text)}</p>"
        "<p>This report states how the tested item behaved in the listed tests on the listed bench. It is not a certificate and not a "
        "conformity test of the Modbus Organization or any manufacturer. Results relate only to the item tested.</p>"
        "<table><tr><th>verdict<th>request<th>section<th>sent<th>heard<th>why</tr>\n"
        f"{rows}</table></html>\n"
    )


def _short(text: str) -> str:
    return text if len(text) <= 90 else text[:87] + "..."


def search(prober: Prober, value: float, unit: int, first: int, last: int) -> tuple[list[Place], int]:
    """Places of the value, and how many registers were read."""
    registers = prober.registers(unit, first, last)
    found = [place for table, words in registers.items() for place in find(value, table, words)]
    return found, sum(map(len, registers.values()))
