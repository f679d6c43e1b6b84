"""A 3964R station at a port: facts from bench and PICS, discovery, stimulation of its own jobs."""

import contextlib
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

from gateway.conformance.framework.bench_file import TIMES, Bench
from gateway.conformance.framework.host import Host
from gateway.conformance.framework.machine import Guarded
from gateway.conformance.framework.peers import Peers
from gateway.conformance.framework.witness import Witness
from gateway.conformance.suites.line import LineSetup, LineTester
from gateway.conformance.suites.rk512.telegrams import Reaction, ask, fetch, finish, is_command, meant_as_command, right_reaction, size_of
from gateway.links.serial.tool_wire import VirtualWire, Wire
from gateway.pure.conformance.verdict import BenchFault, Ended, Fail
from gateway.registry import LINE_LAYERS
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import PROFILES, RHO3, Priority, Profile

BLOCKS = (10, 1, 5, 11, 16, 2, 100)  # that are looked for where the bench names none
MISSING = (99, 255, 200, 77)
LOOKS = 3  # at a word, until there is a reaction
OPERATOR_WAIT, PERIOD = ms(30_000), ms(15_000)
Say = Callable[[str], None]


class LineSession:
    """One run at one wire."""

    def __init__(
        self,
        wire: Wire,
        bench: Bench,
        pics: Mapping[str, object],
        rk512: bool | None,
        say: Say,
        seed: int,
        witness: Witness | None,
    ) -> None:
        """rk512: supported for certain, not tested (False), or to be discovered (None)."""
        self.wire, self._bench, self._rk512, self._say = wire, bench, bool(rk512), say
        self._both = rk512 is None
        self._witness = witness
        self.assumed: list[str] = []
        self._device = wire.station if isinstance(wire, VirtualWire) and isinstance(wire.station, Guarded) else None
        self.pics: dict[str, object] = {**pics}
        self.setup = self._setup(seed)
        self._host = Host(witness, None if wire.simulated else Peers(bench.url))
        self.tester = LineTester(wire, self.setup, self._host)
        if self._layer() is not False:
            self.tester.on_unanswered = self._react

    # ---- facts from bench and PICS
    def _setup(self, seed: int) -> LineSetup:
        link = self._bench.link
        write = tuple(self._bench.touch.get("db", ()))
        known = {key: value for key, value in self._bench.known.items() if isinstance(value, bytes)}
        reaction = link.get("reaction_ms", self._times().get("reaction_ms"))
        setup = LineSetup(self._profile(), self._priority(), write=write, known=known, seed=seed)
        if isinstance(reaction, (int, float)):
            setup.reaction_wait = ms(reaction)
        if isinstance(missing := link.get("missing_db"), int):
            setup.missing = missing
        self._place(setup, link.get("db"))
        if self._device is not None and self._device.hold is not None:
            setup.hold = self._holder(self._device.hold)
        return setup

    def _place(self, setup: LineSetup, named: object) -> None:
        """Which block is read."""
        known = [int(key[2:].partition(".")[0]) for key in setup.known if key.upper().startswith("DB")]
        chosen = [named] if isinstance(named, int) else [*setup.write, *known]
        setup.db = int(chosen[0]) if chosen else BLOCKS[0]
        self._db_known = bool(chosen)

    def _times(self) -> Mapping[str, object]:
        found = self._bench.link.get("times", {})
        return cast(Mapping[str, object], found) if isinstance(found, dict) else {}

    def _profile(self) -> Profile:
        link = self._bench.link
        name = link.get("profile", self.pics.get("profile"))
        profile = PROFILES[str(name)] if name in PROFILES else RHO3
        if name is None:
            self.assumed.append(f"profile {profile.name}: neither bench nor PICS names one")
        changes: dict[str, Any] = {}
        for field, names in TIMES.items():
            for key in names:
                value = self._times().get(key)
                if isinstance(value, (int, float)):
                    changes[field] = int(value) if field.endswith("attempts") else ms(value)
        check = link.get("block_check", self.pics.get("block_check", True))
        profile = replace(profile, **changes) if changes else profile
        return profile if check else profile.plain()

    def _priority(self) -> Priority | None:
        stated = self._bench.link.get("priority", self.pics.get("priority"))
        if stated in ("high", "low"):
            return Priority[str(stated).upper()]
        self.assumed.append("priority: not stated, derived from what the station does in a conflict")
        return None

    def _holder(self, hold: Callable[..., None]) -> Callable[[bool], None]:
        wire = self.wire
        assert isinstance(wire, VirtualWire)
        return lambda on: wire.act(lambda now: hold(on, now))

    # ---- discovery
    def discover(self) -> Mapping[str, object]:
        setup, pics = self.setup, self.pics
        setup.pics = pics
        pics.setdefault("block_check", setup.profile.block_check)
        pics["hold"], pics["write"] = setup.hold is not None, bool(setup.write)
        pics["known"], pics["power"] = bool(setup.known), self.tester.supply is not None
        stated = pics.get("rk512", self._layer())
        with contextlib.suppress(Ended):
            self.tester.settle()
        pics["rk512"] = self._speaks_rk512() if stated is None else bool(stated)
        pics.setdefault("passive", bool(pics["rk512"]))
        self._choose_stimulus()
        pics["sends"] = setup.stimulus is not None
        pics.setdefault("active", self._sends_commands())
        if pics["passive"]:
            self._look_at_blocks()
        self.tester.judges_form = True
        return pics

    def _layer(self) -> bool | None:
        """Whether the bench's layer has blocks by number; None: it names none."""
        layer = self._bench.link.get("layer")
        row = LINE_LAYERS.get(str(layer))
        return None if layer is None else row is not None and row.blocks

    def _speaks_rk512(self) -> bool:
        if self._rk512:
            return True
        try:
            found = ask(self.tester, fetch(self.setup.db, 0, 1))
            if found.number:
                raise Fail(f"FETCH is refused: {found.words()}", "00h", found.words())
        except Ended:
            self.assumed.append("no RK512: a FETCH brought no reaction")
            return False
        self.assumed.append("RK512: a FETCH brought a reaction")
        return True

    def _try(self, db: int, word: int, words: int) -> bool | None:
        """None: no reaction at all.  Repeated after a failure: a size discovered too small would accuse it of serving more."""
        for _ in range(LOOKS):
            try:
                found = ask(self.tester, fetch(db, word, words))
            except Ended:
                with contextlib.suppress(Ended):
                    self.tester.settle()
                continue
            return found.number == 0 and len(found.data) == 2 * words
        return None

    def _look_at_blocks(self) -> None:
        setup = self.setup
        first = self._try(setup.db, 0, 1)
        if first is None:
            return
        if not first and not self._db_known:
            setup.db = next((db for db in BLOCKS if self._try(db, 0, 1)), setup.db)
            self.assumed.append(f"block DB{setup.db}: the first one that can be read")
        stated = self._bench.link.get("words", self.pics.get("words"))
        setup.words = stated if isinstance(stated, int) else self._size(setup.db)
        if setup.words >= 64 and not self._try(setup.db, 0, 64):
            setup.job = next((words for words in (62, 60, 56, 48, 32, 16, 8, 4, 2) if self._try(setup.db, 0, words)), 1)
            self.assumed.append(f"{setup.job} words at most in one job")
        if "missing_db" not in self._bench.link:
            setup.missing = next(
                (db for db in MISSING if db not in (setup.db, *setup.write) and self._try(db, 0, 1) is False), setup.missing
            )
            self.assumed.append(f"missing block: DB{setup.missing}")

    def _size(self, db: int) -> int:
        """Words that can be read, one by one; 256 are all that can be addressed."""
        low, high = 1, 257
        while high - low > 1:
            middle = (low + high) // 2
            if self._try(db, middle - 1, 1):
                low = middle
            else:
                high = middle
        self.setup.size = low
        self.assumed.append(f"DB{db} has {low} words: the last one that can be read")
        return low

    # ---- how it is made to send
    def _choose_stimulus(self) -> None:
        setup, table = self.setup, self._bench.stimulus
        kind = table.get("kind")
        wait = table.get("timeout_ms", table.get("period_ms"))
        setup.stimulus_name = str(kind or "")
        if kind is None and self._device is not None and self._device.stimulate is not None:
            self._by_device()
        elif kind is None and self.pics["passive"]:
            kind = "fetch"
            self.assumed.append("stimulus: a FETCH, whose reaction is the station's block")
        if kind == "fetch":
            setup.stimulus, setup.stimulus_name, setup.stimulus_wait = self._by_fetch, "fetch", setup.reaction_wait
        elif kind == "operator":
            setup.stimulus, setup.stimulus_wait = self._by_operator, OPERATOR_WAIT
        elif kind == "periodic":
            setup.stimulus, setup.stimulus_wait = _by_waiting, PERIOD
        elif kind == "command" or (kind == "output" and "command" in table):
            setup.stimulus = self._by_command
        elif kind in ("modbus", "output"):
            setup.stimulus = self._by_modbus
        if isinstance(wait, (int, float)):
            setup.stimulus_wait = ms(wait if "timeout_ms" in table else 2 * wait + 1000)

    def _by_device(self) -> None:
        device, wire = self._device, self.wire
        assert device is not None and device.stimulate is not None and isinstance(wire, VirtualWire)
        stimulate = device.stimulate
        self.setup.stimulus, self.setup.stimulus_name = lambda tester: _acted(tester, wire, stimulate), "stimulate() of the device"

    def _by_fetch(self, tester: LineTester) -> None:
        with tester.given():
            tester.good(fetch(self.setup.db, 0, max(1, min(8, self.setup.words))), "a FETCH")

    def _by_operator(self, tester: LineTester) -> None:
        self._say(str(self._bench.stimulus.get("prompt") or "Make the station send now"))

    def _by_command(self, tester: LineTester) -> None:
        argv = self._bench.stimulus.get("command")
        if not isinstance(argv, list):
            raise BenchFault("[stimulus] command is missing", "an argument list", "nothing")
        try:
            done = subprocess.run([str(one) for one in argv], cwd=self._bench.folder, timeout=20, capture_output=True, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise BenchFault(f"the stimulus {argv[0]}: {error}", "exit code 0", str(error)) from error
        if done.returncode:
            raise BenchFault(f"the stimulus {argv[0]} ended with {done.returncode}", "exit code 0", str(done.returncode))

    def _by_modbus(self, tester: LineTester) -> None:
        from gateway.conformance.suites.modbus.stimulus import press

        press(self._bench.stimulus)

    def _sends_commands(self) -> bool:
        """Whether its own blocks are RK512 commands; the operator is not asked about it."""
        setup = self.setup
        spoken = self._rk512 or (self._both and self.pics["rk512"])
        if setup.stimulus is None or setup.stimulus_name in ("fetch", "operator") or not spoken:
            return False
        try:
            self.tester.starts_sending()
            block = self.tester.take()
            if not meant_as_command(block.data):
                self.assumed.append(f"not active: its own block {block.data[:10].hex(' ').upper()} is not an RK512 command")
                return False
        except Ended:
            return False
        with contextlib.suppress(Ended):  # its handling of the reaction is another question
            self.tester.good(right_reaction(block.data))
            finish(self.tester, block.data)
        self.assumed.append("active: its own block is an RK512 command")
        return True

    def _react(self, block: bytes) -> bool:
        """An active station may send its next job only after the reaction to the one before."""
        if not is_command(block) or not size_of(block):
            return False
        self.tester.good(right_reaction(block), "the reaction to its own command")
        finish(self.tester, block)
        return True

    # ---- for the runner
    def self_check(self) -> Mapping[str, object]:
        if self.wire.simulated:
            return {"clock": "virtual", "echo": False, "latency_ms": 0.0, "jitter_ms": 0.0}
        start = self.wire.now()
        self.tester.begin()
        self.tester.say(bytes((Char.NAK,)))
        got = self.tester.answer(ms(60))
        jitter = self._witness.late() if self._witness is not None else self.wire.late_ns
        return {
            "clock": "monotonic clock of this host, at the port",
            "echo": got == Char.NAK and self.wire.now() - start < ms(60),
            "latency_ms": round(self.wire.late_ns / 1e6, 3),
            "jitter_ms": round(jitter / 1e6, 3),
            "character_ms": round(self.wire.char_ns / 1e6, 3),
        }

    def begin(self, clean: bool) -> None:
        """After a case that broke off, a job of the station may still wait for its next attempt."""
        self.tester.settle(None if clean else self.setup.profile.ack_delay + ms(300))
        self._host.begin()
        self.tester.begin()

    def alive(self) -> None:
        self.tester.alive()
        if self._rk512 and self.pics.get("passive"):
            found = self._asked()
            if found.number:  # perhaps the answer to our block: some stations answer a reaction
                self.tester.settle()
                found = self._asked()
            if found.number:
                raise Fail(f"FETCH is refused: {found.words()}", "00h", found.words())

    def _asked(self) -> Reaction:
        """The form of its block is judged by cases, not after each of them."""
        tester = self.tester
        judges, tester.judges_form = tester.judges_form, False
        try:
            return ask(tester, fetch(self.setup.db, 0, 1))
        finally:
            tester.judges_form = judges

    def now(self) -> Ns:
        return self.wire.now()

    def rewired(self, wire: Wire) -> None:
        """The port was opened again."""
        self.wire = self.tester.wire = wire

    def close(self) -> None:
        self.wire.close()


def _acted(tester: LineTester, wire: VirtualWire, stimulate: Callable[..., None]) -> None:
    wire.act(stimulate)
    tester.mark = max(tester.mark, wire.now())


def _by_waiting(tester: LineTester) -> None:
    """Wait until it sends on its own."""
    tester.mark = max(tester.mark, tester.wire.now())
