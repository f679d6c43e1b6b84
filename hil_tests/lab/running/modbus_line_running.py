"""A Modbus RTU server of ours on one end of a bare pty; the other end is for a judge."""

import asyncio
import contextlib
import os
import pty
import threading
from typing import Self

from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort, set_raw
from gateway.links.modbus.rtu_server import ModbusLine
from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.base.machine import ms
from protocols.modbus.timing import timing


class RunningLine:
    """`with RunningLine(view) as line:` line.device is what a client opens; bytes go through a thread that copies them, and no more."""

    def __init__(self, view: MemoryView, baud: int = 115200) -> None:
        self.view = view
        self._ours, self._theirs = pty.openpty(), pty.openpty()
        for _, slave in (self._ours, self._theirs):
            set_raw(slave)
        self.device = os.ttyname(self._theirs[1])
        path = os.ttyname(self._ours[1])
        self.server = ModbusLine(
            lambda: PtyPort(path, parse_format(f"{baud} 8N1"), marks=False),
            timing(baud, patience=ms(300)),
            lambda unit: self.view if unit == 1 else None,
        )
        self.loop = asyncio.new_event_loop()
        self.complaints: list[str] = []
        self.loop.set_exception_handler(lambda _, context: self.complaints.append(str(context)))
        self._threads = [threading.Thread(target=self.loop.run_forever, daemon=True)]
        for source, target in ((self._ours[0], self._theirs[0]), (self._theirs[0], self._ours[0])):
            self._threads.append(threading.Thread(target=_copy, args=(source, target), daemon=True))

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        asyncio.run_coroutine_threadsafe(self.server.start(), self.loop).result(10)
        return self

    def __exit__(self, *why: object) -> None:
        asyncio.run_coroutine_threadsafe(self.server.close(), self.loop).result(10)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._threads[0].join(10)
        self.loop.close()
        for _, slave in (self._ours, self._theirs):
            os.close(slave)  # the masters see the end and their threads leave
        for thread in self._threads[1:]:
            thread.join(10)
        for master, _ in (self._ours, self._theirs):
            os.close(master)
        assert self.complaints == []


def _copy(source: int, target: int) -> None:
    with contextlib.suppress(OSError):
        while data := os.read(source, 4096):
            os.write(target, data)
