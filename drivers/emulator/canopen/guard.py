"""Life of an emulated device and of those it watches: heartbeat producer and consumer, node guarding, emergencies with history.

Source: CiA 301, 7.2.7, 7.2.8.3, objects 1001h, 1003h, 100Ch, 100Dh, 1014h, 1015h, 1016h, 1017h; AX-284.
"""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.emulator.canopen.objects import OK, Objects
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import emcy, nmt
from protocols.canopen.emcy import Emergency, Register
from protocols.canopen.nmt import State
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value

NEVER: Ns = 1 << 62
HISTORY, EMCY_ID, EMCY_INHIBIT, CONSUMER, PRODUCER = 0x1003, 0x1014, 0x1015, 0x1016, 0x1017
GUARD_TIME, LIFE_FACTOR = 0x100C, 0x100D
HISTORY_DEPTH = 8


class Emergencies:
    """1001h, 1003h and the messages; `active`: errors whose cause is present."""

    def __init__(self, objects: Objects, send: Callable[[Frame], None]) -> None:
        self._objects, self.send = objects, send
        self.active: dict[int, Register] = {}
        self.history: list[int] = []  # newest first: code, detail in the high word
        self._waiting: list[Emergency] = []
        self._free_at: Ns = 0
        self.due: Ns = NEVER
        self.allowed: Callable[[], bool] = lambda: True  # NMT states pre-operational and operational (CiA 301, 7.3.2.2.4)
        objects.readers[0x1001, 0] = lambda: int(self.register)
        objects.readers[HISTORY, 0] = lambda: len(self.history)
        objects.checks[HISTORY, 0] = lambda value: Abort.VALUE if value else OK
        objects.written[HISTORY, 0] = lambda value: self.history.clear()
        objects.checks[EMCY_ID, 0] = self._check_identifier
        for sub in range(1, HISTORY_DEPTH + 1):
            objects.readers[HISTORY, sub] = self._entry(sub)

    def _entry(self, sub: int) -> Callable[[], Value]:
        return lambda: self.history[sub - 1] if sub <= len(self.history) else Abort.NO_DATA

    def _check_identifier(self, value: Value) -> int:
        new, old = int(value) if isinstance(value, int) else 0, self._objects.whole((EMCY_ID, 0))
        both_valid = not (new | old) & cobid.INVALID
        if new & cobid.EXTENDED or (both_valid and (new ^ old) & cobid.ID_BITS):
            return Abort.VALUE
        return Abort.VALUE if not new & cobid.INVALID and cobid.restricted(new & cobid.ID_BITS) else OK

    @property
    def register(self) -> Register:
        register = Register(0)
        for bits in self.active.values():
            register |= bits | Register.GENERIC
        return register

    def raise_(self, code: int, register: Register, now: Ns, detail: bytes = b"") -> None:
        """A new error; one already present is not reported again."""
        if code in self.active:
            return
        self.active[code] = register
        self.history.insert(0, code | int.from_bytes(detail[:2].ljust(2, b"\0"), "little") << 16)
        del self.history[HISTORY_DEPTH:]
        self._report(Emergency(code, int(self.register), detail[:5].ljust(5, b"\0")), now)

    def clear(self, codes: list[int], now: Ns) -> None:
        """These errors are gone: code 0 once, with the remaining bits of the register (CiA 301, 7.2.7.1)."""
        gone = [code for code in codes if self.active.pop(code, None) is not None]
        if gone:
            self._report(Emergency(0, int(self.register)), now)

    def _report(self, emergency: Emergency, now: Ns) -> None:
        self._waiting.append(emergency)
        self.wake(now)

    def wake(self, now: Ns) -> None:
        identifier = self._objects.whole((EMCY_ID, 0))
        if identifier & cobid.INVALID:
            self._waiting.clear()
        if not self.allowed():
            self.due = NEVER
            return
        while self._waiting and now >= self._free_at:
            self.send(emcy.encode(identifier & cobid.ID_BITS, self._waiting.pop(0)))
            self._free_at = now + self._objects.whole((EMCY_INHIBIT, 0)) * 100_000
        self.due = self._free_at if self._waiting else NEVER

    def reset(self) -> None:
        """Power-up or reset of the application: the history stays until power goes (AX-284)."""
        self.active.clear()
        self._waiting.clear()
        self._free_at, self.due = 0, NEVER


@dataclass(slots=True)
class Watched:
    node: int
    time_ns: Ns
    due: Ns = NEVER  # runs from the first heartbeat on
    lost: bool = False


class Consumer:
    """Watches the heartbeats that 1016h names."""

    def __init__(self, objects: Objects, changed: Callable[[], None]) -> None:
        self._objects, self._changed = objects, changed
        self.watched: dict[int, Watched] = {}
        for entry in objects.dictionary.subs(CONSUMER):
            if entry.sub:
                objects.checks[entry.key] = self._check(entry.sub)
                objects.written[entry.key] = lambda value: self._load_again()
        self.load()

    def _load_again(self) -> None:
        self.load()
        self._changed()

    def _check(self, sub: int) -> Callable[[Value], int]:
        def check(value: Value) -> int:
            node, time = (int(value) >> 16 & 0xFF, int(value) & 0xFFFF) if isinstance(value, int) else (0, 0)
            if not node or not time:
                return OK
            if node > cobid.MAX_NODE:
                return Abort.VALUE
            others = [entry for entry in self._objects.dictionary.subs(CONSUMER) if entry.sub not in (0, sub)]
            words = [self._objects.whole(entry.key) for entry in others]
            return Abort.INCOMPATIBLE if any(word >> 16 & 0xFF == node and word & 0xFFFF for word in words) else OK

        return check

    def load(self) -> None:
        kept, self.watched = self.watched, {}
        for entry in self._objects.dictionary.subs(CONSUMER):
            word = self._objects.whole(entry.key) if entry.sub else 0
            node, time_ns = word >> 16 & 0x7F, (word & 0xFFFF) * 1_000_000
            if node and time_ns:
                old = kept.get(node)
                self.watched[node] = old if old is not None and old.time_ns == time_ns else Watched(node, time_ns)

    def heard(self, node: int, now: Ns) -> bool:
        """A heartbeat; True when the node had been lost and is back."""
        watched = self.watched.get(node)
        if watched is None:
            return False
        back, watched.lost = watched.lost, False
        watched.due = now + watched.time_ns
        return back

    @property
    def due(self) -> Ns:
        return min((watched.due for watched in self.watched.values()), default=NEVER)

    def expired(self, now: Ns) -> list[int]:
        """Nodes whose heartbeat stayed away; each is reported once."""
        lost = [watched for watched in self.watched.values() if watched.due <= now]
        for watched in lost:
            watched.due, watched.lost = NEVER, True
        return [watched.node for watched in lost]

    @property
    def any_lost(self) -> bool:
        return any(watched.lost for watched in self.watched.values())

    def reset(self) -> None:
        self.watched.clear()
        self.load()


class LifeSigns:
    """By which others see that the device lives: its heartbeat (1017h), or answers to node guarding (100Ch, 100Dh) where it has none."""

    def __init__(self, objects: Objects) -> None:
        self._objects = objects
        self.beat_due: Ns = NEVER
        self.life_due: Ns = NEVER  # end of the life time: the guarding master is gone
        self.toggle = False

    @property
    def beat_ns(self) -> Ns:
        return self._objects.whole((PRODUCER, 0)) * 1_000_000

    def reset(self) -> None:
        """No time runs."""
        self.beat_due = self.life_due = NEVER

    def begin(self, at: Ns | None) -> None:
        """The first heartbeat is due one heartbeat time after `at`; None: at once."""
        self.beat_due = NEVER if not self.beat_ns else 0 if at is None else at + self.beat_ns

    def beat(self, number: int, state: State, now: Ns) -> Frame:
        following = self.beat_due + self.beat_ns
        self.beat_due = following if following > now else now + self.beat_ns
        return nmt.heartbeat(number, state)

    def guarded(self, number: int, state: State, now: Ns) -> Frame:
        """The answer to the guarding master; its life time restarts."""
        answer = Frame(cobid.heartbeat(number), bytes((state | nmt.TOGGLE * self.toggle,)))
        self.toggle = not self.toggle
        life = self._objects.whole((GUARD_TIME, 0)) * self._objects.whole((LIFE_FACTOR, 0)) * 1_000_000
        self.life_due = now + life if life else NEVER
        return answer
