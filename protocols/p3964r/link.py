"""3964R, both directions over one line: right to send, one-block buffer, jobs.

Source: rho 3 Releases part 1, section 7.1 (below: 7.1); choices where it is open: AX-003..009, AX-050..052.
"""

from protocols.base.errors import EncodeError
from protocols.base.machine import Damage, Ns
from protocols.p3964r.characters import DLE, NAK, STX
from protocols.p3964r.events import BlockReceived, BlockRefused, Event, Outbox, SamePriority
from protocols.p3964r.profiles import Priority, Profile
from protocols.p3964r.receiver import Receiver
from protocols.p3964r.sender import IDLE, Sender

BLOCK_ENDS = (BlockReceived, BlockRefused)
MOST_TIMERS = 8  # more than can be due at one moment
ANSWERS = (DLE, NAK, STX)  # what a sending station may receive


class Link:
    """A 3964R station: a byte machine that also accepts blocks to send.  Never raises on what the partner sends.

    keep_one: behave as the driver of 7.1: a received block fills the buffer until `take_block` is called; meanwhile no
    further block is acknowledged.  Otherwise the handler of the events reads each block at once (or calls set_buffer_free).
    """

    def __init__(self, profile: Profile, priority: Priority, keep_one: bool = False) -> None:
        self.profile, self.priority = profile, priority
        self._box = Outbox()
        self._receiver = Receiver(profile, self._box, keep_one)
        self._sender = Sender(profile, priority, self._box)
        self._gave_way = False
        self.overtaken_by = 0  # the block received last is older than this job of ours and those after it, though it came later (AX-242)
        self._given_at: Ns = 0
        self._greet()

    # ---- for its owner
    def send(self, block: bytes, now: Ns, follow_on: bool = False) -> int:
        """Queue a block of 1..max_data bytes; returns the job number that BlockSent or SendFailed will name.

        follow_on: it continues the one before; some stations end such blocks with DLE ETB.
        """
        if not 1 <= len(block) <= self.profile.max_data:
            raise EncodeError(f"block of {len(block)} bytes, limit {self.profile.max_data} (least 1): {block[:16].hex(' ')}")
        job = self._sender.add(block, self.profile.follow_on_end if follow_on else self.profile.end)
        self._given_at = now
        self._start(now)
        return job

    def replace(self, job: int, block: bytes, follow_on: bool = False) -> bool:
        """Send this block instead of the one queued under that number; False: that one is on the line already, or the job is over."""
        return self._sender.replace(job, block, self.profile.follow_on_end if follow_on else self.profile.end)

    def revoke(self) -> None:
        """Take the first job back, if there is one: a block on the line is ended but not repeated; it ends with REVOKED, or sent."""
        self._sender.revoke()

    @property
    def untaken(self) -> bool:
        """Output that no port has accepted."""
        return bool(self._box.output)

    @property
    def receiving(self) -> bool:
        """The partner has the line: a block of it is under way."""
        return self._receiver.busy

    @property
    def pending(self) -> int:
        """Jobs neither sent nor aborted."""
        return len(self._sender.jobs)

    def set_buffer_free(self, free: bool, now: Ns) -> None:
        """False: no block can be accepted; STX is answered with silence, then NAK.  True: a waiting STX is answered at once."""
        self._receiver.set_free(free, now)

    def take_block(self, now: Ns) -> bytes | None:
        """The block kept since it was acknowledged, once; the buffer is free again (keep_one)."""
        return self._receiver.take_block(now)

    # ---- the machine
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        due = self._next_due()
        if due is not None and due <= now:
            self._expire(now)  # what expired before these bytes came is reported first
        sender = self._sender
        at, size = 0, len(data)
        while at < size:
            if sender.state is IDLE:
                at = self._listen(data, at, now)
            elif sender.hear(data[at], now):
                if data[at] not in ANSWERS:
                    self._receiver.disquiet(now)
                at += 1
            else:
                self._gave_way = True
                at = self._listen(data, at, now)
            if sender.jobs and sender.state is IDLE:
                self._start(now)
        return self._box.take_events() if self._box.events else []

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        self._expire(now)
        if self._sender.busy:
            self._sender.damaged(kind, now)
        else:
            self._receiver.damaged(kind, now)
        self._start(now)
        return self._box.take_events()

    def sent(self, now: Ns) -> list[Event]:
        box, sender = self._box, self._sender
        if not box.output:  # else the report is older than our present output
            if sender.state is not IDLE:
                sender.sent(now)
            self._receiver.sent(now)
            if sender.jobs and sender.state is IDLE:
                self._start(now)
        return box.take_events() if box.events else []

    def wake(self, now: Ns) -> list[Event]:
        self._expire(now)
        return self._box.take_events()

    def deadline(self) -> Ns | None:
        if self._box.events:  # left over from `send`
            return self._given_at
        return self._next_due()

    def take_output(self) -> bytes:
        box = self._box
        return box.take_output() if box.output else b""

    def lost(self, now: Ns) -> list[Event]:
        self._box.output.clear()
        self._receiver.lost()
        self._sender.lost()
        self._gave_way = False
        self._greet()
        return self._box.take_events()

    # ---- inside
    def _greet(self) -> None:
        if self.profile.nak_at_start:
            self._box.say(NAK)  # sends a partner that hangs inside a block to idle

    def _listen(self, data: bytes, at: int, now: Ns) -> int:
        known = len(self._box.events)
        receiver = self._receiver
        at = receiver.hear(data, at, now)
        if not receiver.busy:
            self._gave_way = False
            for event in self._box.events[known:]:
                if isinstance(event, BLOCK_ENDS):
                    self._sender.forget_attempts()
                if isinstance(event, BlockReceived):
                    self.overtaken_by, self._sender.overtook = self._sender.overtook, 0
        return at

    def _start(self, now: Ns) -> None:
        """The line is free: our next job may begin."""
        if self._sender.jobs and not self._sender.busy and not self._receiver.busy:
            self._receiver.settle()
            self._sender.start(now)

    def _next_due(self) -> Ns | None:
        receiver = self._receiver
        due, character, repeat = self._sender.due, receiver.due, receiver.repeats.due  # read twice per burst: no call
        if character is not None and (due is None or character < due):
            due = character
        return repeat if repeat is not None and (due is None or repeat < due) else due

    def _expire(self, now: Ns) -> None:
        rounds = 0
        while (due := self._next_due()) is not None and due <= now and rounds < MOST_TIMERS:  # each timer ends or moves on
            rounds += 1
            if due == self._sender.due:
                self._sender.expire(now)
            else:
                if self._gave_way and self.priority is Priority.LOW and self._receiver.heard_only_dle:
                    self._box.report(SamePriority(Priority.LOW))
                self._receiver.expire(now)
                self._gave_way = self._gave_way and self._receiver.busy
            self._start(now)
