"""Process image: regions and rings in memfds, one writing process each, any number of readers, without waiting.

Source: docs/architecture.md, "Processes, regions, restart"; AX-090 (bytes), AX-091 (store order and take-over).

A region shows the newest payload: 4 slots, the writer fills the next one and publishes with one aligned 64-bit store; a reader copies and
then checks whether the writer could have reached its slot again.  A ring shows every record, once, in order, to readers that keep up; the
others count what they missed.  Flow control, if needed, is up to the user: a consumer reports `RingReader.position` in a region of its own.
"""

import fcntl
import hashlib
import json
import mmap
import os
import socket
import threading
from collections.abc import Mapping
from pathlib import Path

LAYOUT_VERSION = 1
SLOTS = 4
REGION_MAGIC = int.from_bytes(b"AXREGION", "little")
RING_MAGIC = int.from_bytes(b"AXRING__", "little")
HEADER_BYTES = 256
SLOT_HEADER_BYTES = 16  # stamp ns, spare
TRIES = 2  # a reader copies at most twice, then keeps what it has
# Words (8 bytes, native order) of the header
MAGIC, VERSION, HASH, SIZE, COUNT, WRITER, PUBLISHED, LIFE, LIFE_STAMP, GENERATION, GENERATION_START = 0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11
NAME_AT, NAME_BYTES, LAYOUT_AT, LAYOUT_BYTES = 128, 32, 160, 96
MAX_FDS = 250  # SCM_MAX_FD of Linux is 253

_barrier = threading.Lock()


class ImageError(Exception):
    """A region or ring that differs from the caller's expectation; the message names both."""


def _fence() -> None:
    """Stores before it are seen before stores after it: the first release and the second acquire (x86-64 would not need it).  Taken
    twice, not left held in between: the services read and write from several threads."""
    with _barrier:
        pass
    with _barrier:
        pass


def _hash(layout: str) -> int:
    return int.from_bytes(hashlib.blake2b(layout.encode(), digest_size=8).digest(), "little")


def _stride(kind: int, size: int) -> int:
    head = SLOT_HEADER_BYTES if kind == REGION_MAGIC else 0
    return (head + size + 63) // 64 * 64 if kind == REGION_MAGIC else (size + 7) // 8 * 8


def _create(kind: int, name: str, size: int, count: int, layout: str) -> int:
    """Fd of a fresh, sealed memfd with its header."""
    if size < 1 or count < 2:
        raise ImageError(f"{name}: {count} slots of {size} bytes; at least 2 of 1 byte")
    if not name or len(name.encode()) > NAME_BYTES:
        raise ImageError(f"{name!r}: a name has 1 to {NAME_BYTES} bytes")
    fd = os.memfd_create(f"axisgate-{name}", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        os.ftruncate(fd, HEADER_BYTES + count * _stride(kind, size))
        with mmap.mmap(fd, HEADER_BYTES) as header, memoryview(header) as octets, octets.cast("Q") as words:
            for at, value in (
                (VERSION, LAYOUT_VERSION),
                (HASH, _hash(layout)),
                (SIZE, size),
                (COUNT, count),
                (GENERATION, 1),
                (MAGIC, kind),
            ):
                words[at] = value
            octets[NAME_AT : NAME_AT + len(name.encode())] = name.encode()
            shown = layout.encode()[:LAYOUT_BYTES]
            octets[LAYOUT_AT : LAYOUT_AT + len(shown)] = shown
        # Sealed size: nobody can shrink it under a reader, which would kill the reader with SIGBUS
        fcntl.fcntl(fd, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
    except BaseException:
        os.close(fd)
        raise
    return fd


def create_region(name: str, payload_size: int, layout: str = "") -> int:
    """New memfd (close-on-exec) for one region; `layout` is any text that changes when the payload's meaning changes."""
    return _create(REGION_MAGIC, name, payload_size, SLOTS, layout)


def create_ring(name: str, record_size: int, records: int, layout: str = "") -> int:
    """New memfd (close-on-exec) for one ring of `records` fixed records; a reader may lag by at most records - 1."""
    return _create(RING_MAGIC, name, record_size, records, layout)


def _identity() -> int:
    """This process: pid in the low half, its start time in the high half, so that a reused pid is not mistaken for the writer."""
    return os.getpid() | _start_ticks(os.getpid()) << 32


def _start_ticks(pid: int) -> int:
    """Start time (clock ticks, low 32 bits) of a living process, 0 for none or a zombie.  Source: proc(5), stat fields 3 and 22."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0
    return 0 if fields[0] in "ZX" else int(fields[19]) & 0xFFFFFFFF


class _Mapped:
    """The common part of readers and writers: a checked mapping."""

    def __init__(self, fd: int, kind: int, name: str | None, layout: str | None, writable: bool) -> None:
        size = os.fstat(fd).st_size
        if size < HEADER_BYTES:
            raise ImageError(f"{name or f'fd {fd}'}: {size} bytes, the header has {HEADER_BYTES}")
        self._map = mmap.mmap(fd, size, mmap.MAP_SHARED, mmap.PROT_READ | (mmap.PROT_WRITE if writable else 0))
        self._octets = memoryview(self._map)
        self._words = self._octets[: size // 8 * 8].cast("Q")
        try:
            self._check(kind, name, layout)
        except ImageError:
            self.close()
            raise
        self.size = self._words[SIZE]
        self.count = self._words[COUNT]
        self._stride = _stride(kind, self.size)

    def _text(self, at: int, size: int) -> str:
        return bytes(self._octets[at : at + size]).rstrip(b"\0").decode(errors="replace")

    def _check(self, kind: int, name: str | None, layout: str | None) -> None:
        words = self._words
        self.name = self._text(NAME_AT, NAME_BYTES)
        expected = name or self.name or "image"
        for what, found, wanted in (("magic", words[MAGIC], kind), ("layout version", words[VERSION], LAYOUT_VERSION)):
            if found != wanted:
                raise ImageError(f"{expected}: {what} {wanted:#x} expected, {found:#x} found")
        if name is not None and name != self.name:
            raise ImageError(f"{name!r} expected, the memory is {self.name!r}")
        if layout is not None and _hash(layout) != words[HASH]:
            found_layout = self._text(LAYOUT_AT, LAYOUT_BYTES)
            raise ImageError(f"{expected}: layout {layout!r} ({_hash(layout):016x}) expected, {found_layout!r} ({words[HASH]:016x}) found")
        needed = HEADER_BYTES + words[COUNT] * _stride(kind, words[SIZE])
        if needed != len(self._octets):
            raise ImageError(f"{expected}: {needed} bytes expected by its header, {len(self._octets)} found")

    @property
    def life(self) -> tuple[int, int]:
        """(count, stamp ns) of the writer's last beat; (0, 0) before the first."""
        words = self._words
        for _ in range(TRIES):
            count = words[LIFE]
            stamp = words[LIFE_STAMP + (count & 1)]
            _fence()
            if words[LIFE] == count:
                break
        return count, stamp

    @property
    def writer_pid(self) -> int:
        """Pid of the present writer, or of one that died as such; 0: never had one, or it closed."""
        return self._words[WRITER] & 0xFFFFFFFF

    @property
    def published(self) -> int:
        """How often the writer published: payloads of a region, records of a ring."""
        return self._words[PUBLISHED]

    @property
    def octets(self) -> memoryview:
        """Header and slots, for readers in C (gateway.cycle.native)."""
        return self._octets

    def close(self) -> None:
        """Unmap; the fd stays the caller's."""
        self._words.release()
        self._octets.release()
        self._map.close()


class _Writer(_Mapped):
    """The writing side: becomes the writer at once, unless another living process is it."""

    def __init__(self, fd: int, kind: int, name: str | None, layout: str | None) -> None:
        super().__init__(fd, kind, name, layout, writable=True)
        before, me = self._words[WRITER], _identity()
        if before not in (0, me) and _start_ticks(before & 0xFFFFFFFF) == before >> 32:
            super().close()
            raise ImageError(f"{self.name}: has a living writer, pid {before & 0xFFFFFFFF}; this is pid {me & 0xFFFFFFFF}")
        self._store(self._words, WRITER, me)

    def _store(self, view: memoryview, at: int, value: int) -> None:
        """Every 64-bit store of a writer; tests override it to die here."""
        view[at] = value

    def _fill(self, at: int, octets: bytes | bytearray | memoryview) -> None:
        """Every store of payload bytes; tests override it to die in the middle."""
        self._octets[at : at + len(octets)] = octets

    def beat(self, stamp_ns: int) -> None:
        """Life counter + 1; count and stamp are published together."""
        count = self._words[LIFE] + 1
        self._store(self._words, LIFE_STAMP + (count & 1), stamp_ns)
        _fence()
        self._store(self._words, LIFE, count)

    def close(self) -> None:
        """Stop writing, so that another living process may take over; unmap."""
        if self._words[WRITER] == _identity():
            self._store(self._words, WRITER, 0)
        super().close()

    def _sized(self, octets: bytes | bytearray | memoryview) -> None:
        if len(octets) != self.size:
            raise ImageError(f"{self.name}: {self.size} bytes expected, {len(octets)} given")


class RegionWriter(_Writer):
    """Writes one region.  Taking over after a predecessor's death continues its index, life counter and last payload."""

    def __init__(self, fd: int, name: str | None = None, layout: str | None = None) -> None:
        super().__init__(fd, REGION_MAGIC, name, layout)

    def write(self, payload: bytes | bytearray | memoryview, stamp_ns: int) -> int:
        """Publish a payload of exactly the region's size; its index (1 for the first)."""
        self._sized(payload)
        index = self._words[PUBLISHED] + 1
        at = HEADER_BYTES + index % SLOTS * self._stride
        self._store(self._words, at // 8, stamp_ns)
        self._fill(at + SLOT_HEADER_BYTES, payload)
        _fence()
        self._store(self._words, PUBLISHED, index)
        return index

    def latest(self) -> bytes | None:
        """The last published payload, also a predecessor's; None: nothing was ever published."""
        index = self._words[PUBLISHED]
        at = HEADER_BYTES + index % SLOTS * self._stride + SLOT_HEADER_BYTES
        return bytes(self._octets[at : at + self.size]) if index else None


class RegionReader(_Mapped):
    """Reads one region.  `overtaken` counts copies thrown away, `kept` the reads that had to return the old copy."""

    def __init__(self, fd: int, name: str | None = None, layout: str | None = None) -> None:
        super().__init__(fd, REGION_MAGIC, name, layout, writable=False)
        self.index, self.stamp_ns, self.overtaken, self.kept = 0, 0, 0, 0
        self._copy: bytes | None = None

    def read(self) -> bytes | None:
        """The newest complete payload; None: nothing was published yet.  `index` and `stamp_ns` belong to it."""
        words = self._words
        for _ in range(TRIES):
            index = words[PUBLISHED]
            if index == self.index:
                return self._copy
            at = HEADER_BYTES + index % SLOTS * self._stride
            stamp = words[at // 8]
            copy = self._take(at + SLOT_HEADER_BYTES)
            _fence()
            if words[PUBLISHED] - index <= SLOTS - 2:  # the writer fills at most index + 3: not yet our slot
                self.index, self.stamp_ns, self._copy = index, stamp, copy
                return copy
            self.overtaken += 1
        self.kept += 1
        return self._copy

    def _take(self, at: int) -> bytes:
        """The copy itself; tests override it to be overtaken here."""
        return bytes(self._octets[at : at + self.size])


class RingWriter(_Writer):
    """Puts records into one ring; never blocks: the oldest record is overwritten."""

    def __init__(self, fd: int, name: str | None = None, layout: str | None = None) -> None:
        super().__init__(fd, RING_MAGIC, name, layout)

    def put(self, record: bytes | bytearray | memoryview) -> int:
        """Publish a record of exactly the ring's record size; its sequence number (1 for the first)."""
        self._sized(record)
        sequence = self._words[PUBLISHED] + 1
        self._fill(HEADER_BYTES + sequence % self.count * self._stride, record)
        _fence()
        self._store(self._words, PUBLISHED, sequence)
        return sequence

    def new_generation(self) -> int:
        """All records so far are void for readers that have not read them yet; returns the new generation's number."""
        generation = self._words[GENERATION] + 1
        self._store(self._words, GENERATION_START + (generation & 1), self._words[PUBLISHED])
        _fence()
        self._store(self._words, GENERATION, generation)
        return generation


class RingReader(_Mapped):
    """Reads records in order.  A new reader starts at the end: old records never replay.

    `position` is the last sequence number read or skipped, `gaps` counts records lost because the writer lapped the reader, `voided` those
    a new generation made void, `overtaken` the copies discarded.
    """

    def __init__(self, fd: int, name: str | None = None, layout: str | None = None) -> None:
        super().__init__(fd, RING_MAGIC, name, layout, writable=False)
        self.position, self.generation = self._words[PUBLISHED], self._words[GENERATION]
        self.gaps, self.voided, self.overtaken = 0, 0, 0

    @property
    def waiting(self) -> int:
        """Records present and not read."""
        return max(self._words[PUBLISHED] - self.position, 0)

    def take(self, limit: int = 64) -> list[tuple[int, bytes]]:
        """At most `limit` records with their sequence numbers, oldest first; [] when nothing waits."""
        for _ in range(TRIES):
            self._enter_generation()
            newest = self._words[PUBLISHED]
            self._skip_to(newest + 1 - self.count)
            numbers = range(self.position + 1, min(newest, self.position + limit) + 1)
            taken = [(number, self._take(HEADER_BYTES + number % self.count * self._stride)) for number in numbers]
            _fence()
            if self._words[GENERATION] != self.generation:
                self.overtaken += 1
                continue
            void = self._words[PUBLISHED] + 1 - self.count  # the writer may be filling the slot of this number right now
            whole = [item for item in taken if item[0] > void]
            if taken and not whole:
                self.overtaken += 1
                continue
            self._skip_to(void)
            self.position = whole[-1][0] if whole else self.position
            return whole
        return []

    def _take(self, at: int) -> bytes:
        """The copy itself; tests override it to be overtaken here."""
        return bytes(self._octets[at : at + self.size])

    def _skip_to(self, lost: int) -> None:
        """Records up to `lost` can no longer be had."""
        if lost > self.position:
            self.gaps += lost - self.position
            self.position = lost

    def _enter_generation(self) -> None:
        generation = self._words[GENERATION]
        if generation == self.generation:
            return
        start = self._words[GENERATION_START + (generation & 1)]
        self.voided += max(0, start - self.position)
        self.position = max(self.position, start)
        self.generation = generation


def fds_to_text(fds: Mapping[str, int]) -> str:
    """`axes=5,links=6`: for a child's command line; the fds themselves go through pass_fds."""
    return ",".join(f"{name}={fd}" for name, fd in fds.items())


def fds_from_text(text: str) -> dict[str, int]:
    """The other way round; ImageError names the part that is not NAME=NUMBER."""
    fds: dict[str, int] = {}
    for part in filter(None, text.split(",")):
        name, equals, number = part.partition("=")
        if not (name and equals and number.isdecimal()):
            raise ImageError(f"{part!r}: NAME=NUMBER expected, in {text!r}")
        fds[name] = int(number)
    return fds


def send_fds(connection: socket.socket, fds: Mapping[str, int]) -> None:
    """Pass named fds through a Unix stream socket (SCM_RIGHTS): length (4 bytes, little endian), JSON list of names."""
    if len(fds) > MAX_FDS:
        raise ImageError(f"{len(fds)} fds; one message carries {MAX_FDS}")
    names = json.dumps(list(fds)).encode()
    message = len(names).to_bytes(4, "little") + names
    sent = socket.send_fds(connection, [message], list(fds.values()))
    connection.sendall(message[sent:])


def recv_fds(connection: socket.socket) -> dict[str, int]:
    """Named fds from the other side (close-on-exec, the caller closes them); waits for the socket's time-out."""
    message, numbers, flags, _ = socket.recv_fds(connection, 4, MAX_FDS, socket.MSG_CMSG_CLOEXEC)
    try:
        size = int.from_bytes(message + _exactly(connection, 4 - len(message)), "little")
        names = json.loads(_exactly(connection, size))
        if flags & socket.MSG_CTRUNC or len(names) != len(numbers):
            raise ImageError(f"{len(names)} fds announced, {len(numbers)} received")
    except BaseException:
        for number in numbers:
            os.close(number)
        raise
    return dict(zip(names, numbers, strict=True))


def _exactly(connection: socket.socket, size: int) -> bytes:
    octets = bytearray()
    while len(octets) < size:
        part = connection.recv(size - len(octets))
        if not part:
            raise ImageError(f"{size} bytes expected, {len(octets)} received before the other side closed")
        octets += part
    return bytes(octets)
