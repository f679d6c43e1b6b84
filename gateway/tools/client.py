"""A commissioning command's end of the tool command source: connects to a running cell, or runs the cell under simulation for the duration
of the command.
"""

import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence

from drivers.ports.base import PortError, runtime_dir
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisFlag
from gateway.runtime.supervisor_client import wait_up

POLL_S = 0.05
ALIVE_S = 0.25  # reading is not a sign of life: the client in control sends one at this interval
START_UP_S = 40.0
UNHURRIED_MS = 8  # clock of a simulation that measures times: a shared computer loses 5 ms now and then
Row = dict[str, object]
ENDING = (signal.SIGINT, signal.SIGTERM)  # Ctrl-C, and a polite end


class ToolError(Exception):
    """A refusal of the cell, in a sentence."""


@contextlib.contextmanager
def heeded() -> Iterator[None]:
    """Raise KeyboardInterrupt at Ctrl-C and at a polite end within this block.

    Also in a background job of a shell: it starts with SIGINT ignored, and a program that was to end by it would never be stopped.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = [signal.signal(number, signal.default_int_handler) for number in ENDING]
    try:
        yield
    finally:
        for number, handler in zip(ENDING, before, strict=True):
            signal.signal(number, handler)


@contextlib.contextmanager
def interrupt_later() -> Iterator[None]:
    """Raise KeyboardInterrupt after this block, not within it; outside the main thread Python raises none."""
    main = threading.current_thread() is threading.main_thread()
    held = [number for number in ENDING if main and signal.getsignal(number) is signal.default_int_handler]
    came: list[int] = []
    try:
        for number in held:
            signal.signal(number, lambda got, _: came.append(got))
        yield
    finally:
        for number in held:
            signal.signal(number, signal.default_int_handler)
        if came:
            raise KeyboardInterrupt


class ToolClient:
    """Requests and answers, one JSON line each."""

    def __init__(self, run: str) -> None:
        self.run = run
        self._holds, self._said = False, 0.0  # in control, and time of its last sign of life
        self._link = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._link.settimeout(5.0)
        try:
            self._link.connect(str(runtime_dir() / f"{run}-services.sock"))
        except OSError as error:
            raise ToolError(f"run {run!r} does not answer ({error.strerror}); start it with: axisgate run CELL") from error
        self._file = self._link.makefile("rb")

    def ask(self, op: str, **request: object) -> Row:
        """One request; ToolError for an error.  In control it is also a sign of life."""
        if self._holds and op != "tool" and time.monotonic() - self._said > ALIVE_S:
            self._said = time.monotonic()
            self._asked("alive", {})
        answer = self._asked(op, request)
        if op == "tool" and request.get("code") in ("request_control", "release_control") and answer.get("state") != "REFUSED":
            self._holds = request["code"] == "request_control"
        return answer

    def _asked(self, op: str, request: Mapping[str, object]) -> Row:
        try:
            with interrupt_later():  # or the answer to this request would be read as the answer to the next one
                self._link.sendall(json.dumps({"op": op, **request}).encode() + b"\n")
                answer: Row = json.loads(self._file.readline() or b"{}")
        except (OSError, ValueError) as error:
            raise ToolError(f"run {self.run!r}: the services process has ended ({error})") from error
        if "error" in answer:
            raise ToolError(str(answer["error"]))
        return answer

    def axes(self) -> list[Row]:
        """Every axis as the cycle published it last."""
        rows = self.ask("axes")["axes"]
        assert isinstance(rows, list)
        return rows

    def axis(self, name: str) -> Row:
        """One of them; ToolError names those that exist."""
        rows = self.axes()
        for row in rows:
            if row["name"] == name:
                return row
        raise ToolError(f"axis {name}: no such axis; there is {', '.join(str(row['name']) for row in rows)}")

    def command(self, code: str, mask: int = 0, *, timeout_s: float = 30.0, **rest: object) -> Row:
        """Until it is done; ToolError when it is refused, aborted or late."""
        answer = self.ask("tool", code=code, mask=mask, **rest)
        end = time.monotonic() + timeout_s
        while answer["open"] and time.monotonic() < end:
            time.sleep(POLL_S)
            answer = self.ask("job", job=answer["job"])
        if answer["state"] != "DONE":
            raise ToolError(f"{code}: {answer['state']} {answer['words']} {answer['detail']} {self._faults()}".rstrip())
        return answer

    def _faults(self) -> str:
        """Axes with a fault, and the fault."""
        return "; ".join(f"{row['name']}: {row['words']}" for row in self.axes() if row["words"])

    def sdo(self, axis: str, index: int, sub: int = 0, data: bytes | None = None) -> bytes:
        """An object read, or written with `data`."""
        extra = {} if data is None else {"data": data.hex()}
        ticket = self.ask("sdo", axis=axis, index=index, sub=sub, **extra)["ticket"]
        answer: Row = {"pending": True}
        while "pending" in answer:
            time.sleep(POLL_S)
            answer = self.ask("ticket", ticket=ticket)
        return bytes.fromhex(str(answer["data"]))

    def wait_ready(self, timeout_s: float = START_UP_S) -> None:
        """Every drive is started up; ToolError names those that are not, and why."""
        end = time.monotonic() + timeout_s
        while True:
            rows = self.axes()
            waiting = [row for row in rows if int(str(row["flags"])) & (AxisFlag.UNCONFIGURED | AxisFlag.LOST)]
            if rows and not waiting and self.ask("axes")["cycle"]:
                return
            if time.monotonic() > end:
                raise ToolError("; ".join(f"{row['name']}: {row['why'] or 'no telegram'}" for row in waiting) or "the cycle does not run")
            time.sleep(POLL_S)

    def take_over(self) -> None:
        """Control, enabling inputs of a simulation, faults reset, override 100 %."""
        if self.ask("axes")["simulated"]:
            self.ask("permit")
            time.sleep(0.1)
        for code in ("request_control", "fault_reset", "override"):
            self.command(code)

    def close(self) -> None:
        self._file.close()
        self._link.close()


def mask_of(cell: Cell, names: Sequence[str]) -> int:
    """Bit n-1 for axis n."""
    return sum(1 << n for n, axis in enumerate(cell.axis) if axis.name in names)


@contextlib.contextmanager
def running(run: str) -> Iterator[ToolClient]:
    """A cell that is up already."""
    client = ToolClient(run)
    try:
        yield client
    finally:
        client.close()


@contextlib.contextmanager
def simulated(cell: str, p5_ms: int | None = None, bus: str | None = None) -> Iterator[tuple[ToolClient, pathlib.Path]]:
    """The cell under simulation in a runtime folder of its own, and the folder of its records.

    `p5_ms`: runs in real time; without it simulated time waits for a late machine (AX-681).
    `bus`: a CAN port instead of the broker.
    """
    before = os.environ.get("AXISGATE_RUNTIME")
    with tempfile.TemporaryDirectory(prefix="axg-", dir="/tmp") as folder:
        os.environ["AXISGATE_RUNTIME"] = f"{folder}/run"
        command = [sys.executable, "-m", "gateway", "run", cell, "--sim", "--name", "tool", "--modbus-port", "0", "--record", folder]
        command += [*(("--p5", str(p5_ms)) if p5_ms else ()), *(("--bus", bus) if bus else ())]
        process = subprocess.Popen(
            [*command, "--die-with-parent"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            if not wait_up("tool", 30.0):
                raise ToolError(f"{cell} did not start under simulation; axisgate run {cell} --sim reports why")
            client = _patiently("tool")
            try:
                yield client, pathlib.Path(folder)
            finally:
                client.close()
        except PortError as error:
            raise ToolError(str(error)) from error
        finally:
            process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(15)
            process.kill()
            process.wait()
            if before is None:
                del os.environ["AXISGATE_RUNTIME"]
            else:
                os.environ["AXISGATE_RUNTIME"] = before


def _patiently(run: str) -> ToolClient:
    """Its services may still be opening their socket."""
    for _ in range(100):
        with contextlib.suppress(ToolError):
            return ToolClient(run)
        time.sleep(0.1)
    return ToolClient(run)
