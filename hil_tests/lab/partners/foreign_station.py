"""A 3964R station with a passive RK512 above it, at the master end of a bare pty or a descriptor: written by hand, in real time.

It shares nothing with protocols and sends plain characters: no marks, FF as FF.  It has DB 10 with 128 words and no other block, and
high priority.  It receives a block or sends one, never both at the same time.
"""

import os
import select
import threading
import time

QVZ, ZVZ = 0.55, 0.22
WORDS = 128


class ForeignStation:
    """Runs in a thread; `path` is what others open.  `heard` are the blocks it received, `sent` those it sent."""

    def __init__(self, *, answers: bool = True) -> None:
        self._fd, self._slave = os.openpty()
        self.path = os.ttyname(self._slave)
        self.block = bytearray((at * 7 + 3) % 256 for at in range(2 * WORDS))
        self.block[0:4] = b"\xff\xff\x10\xff"
        self.heard: list[bytes] = []
        self.sent: list[bytes] = []
        self.refuses = 0  # error number for every job
        self._answers = answers
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)

    def __enter__(self) -> "ForeignStation":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(5)
        os.close(self._fd)
        os.close(self._slave)

    def say(self, data: bytes) -> None:
        """Characters nobody asked for."""
        os.write(self._fd, data)

    # ---- the station
    def _character(self, seconds: float) -> int | None:
        """What is there when the time is over came in time: this thread was late, not its partner."""
        end = time.monotonic() + seconds
        while not self._over.is_set():
            left = end - time.monotonic()
            if select.select([self._fd], [], [], max(0.0, min(left, 0.05)))[0]:
                return os.read(self._fd, 1)[0]
            if left <= 0:
                return None
        return None

    def _live(self) -> None:
        while not self._over.is_set():
            if self._character(0.2) == 0x02 and self._answers:
                command = self._receive()
                if command is not None and len(command) >= 10 and command[0] == 0:
                    self._give(self._reaction(command))

    def _receive(self) -> bytes | None:
        self.say(b"\x10")
        data, check, doubled = b"", 0, False
        while True:
            character = self._character(ZVZ)
            if character is None:
                self.say(b"\x15")
                return None
            check ^= character
            if doubled and character == 0x03:
                break
            if doubled or character != 0x10:
                data += bytes([character])
            doubled = character == 0x10 and not doubled
        good = self._character(ZVZ) == check
        self.say(b"\x10" if good else b"\x15")
        if good:
            self.heard.append(data)
        return data if good else None

    def _reaction(self, command: bytes) -> bytes:
        first, amount = 2 * command[5], 2 * int.from_bytes(command[6:8], "big")
        if self.refuses:
            return bytes((0, 0, 0, self.refuses))
        if command[4] != 10 or first + amount > len(self.block):
            return b"\0\0\0\x14"
        if command[2] == 0x45:
            return bytes(4) + bytes(self.block[first : first + amount])[:128]
        if len(command) != 10 + amount:
            return b"\0\0\0\x34"
        self.block[first : first + amount] = command[10:]
        return bytes(4)

    def _give(self, data: bytes) -> None:
        wire, check = data.replace(b"\x10", b"\x10\x10") + b"\x10\x03", 0
        for byte in wire:
            check ^= byte
        for _ in range(6):
            self.say(b"\x02")
            answer = self._character(QVZ)
            while answer == 0x02:  # it has priority
                answer = self._character(QVZ)
            if answer != 0x10:
                continue
            self.say(wire + bytes([check]))
            if self._character(QVZ) == 0x10:
                self.sent.append(data)
                return
        self.say(b"\x15")
