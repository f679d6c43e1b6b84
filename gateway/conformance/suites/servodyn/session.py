"""A SERVODYN booster at a bus: which module, which layout; before each case it is at rest."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from gateway.conformance.framework.bench_file import BadFile
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.servodyn.booster import BoosterSetup, BoosterTester
from gateway.conformance.suites.supply import frame_supply
from gateway.files.dbc import load_servodyn
from gateway.files.find import find_config
from gateway.pure.conformance.verdict import Ended
from protocols.base.errors import DecodeError, EncodeError
from protocols.base.machine import Ns, ms
from protocols.servodyn.codec import SYNC, Codec

ITEMS = ("parameters", "life", "position")


class BoosterSession:
    """One run."""

    def __init__(self, opened: Opened) -> None:
        self._opened = opened
        bench = opened.bench
        self.assumed: list[str] = []
        self.pics: dict[str, object] = dict(opened.pics)
        self.setup = BoosterSetup(_codec(opened))
        for name in ("cycle", "boot", "stop"):
            if isinstance(value := bench.link.get(f"{name}_ms"), (int, float)):
                setattr(self.setup, name, ms(value))
        if isinstance(value := bench.link.get("answer_ms"), (int, float)):
            self.setup.wait = ms(value)
        if isinstance(way := bench.link.get("way"), int):
            self.setup.way, self.setup.way_stated = way, True
        if isinstance(turn := bench.link.get("turn"), int):
            self.setup.turn = turn
        stated = bench.link.get("module", self.pics.get("module"))
        self._module = stated if isinstance(stated, int) else None
        self.setup.module = self._module or 1
        witness = opened.witness
        self.tester = BoosterTester(opened.bus, self.setup, witness.late if witness is not None else lambda: 0)

    def discover(self) -> Mapping[str, object]:
        tester, pics, bench = self.tester, self.pics, self._opened.bench
        tester.supply = frame_supply(self._opened, tester)
        pics["power"] = tester.supply is not None
        tester.pause(ms(200))
        self.setup.pics = pics
        if self._module is None:
            self._find()
        pics["may_move"] = tester.wire.simulated or "motion" in bench.allowed
        pics["may_store"] = tester.wire.simulated or "store" in bench.allowed
        with suppress(Ended):
            tester.turn(25)
        if "parameters" not in pics:
            pics["parameters"] = self._has_parameters()
        pics.setdefault("life", True)
        return pics

    def _find(self) -> None:
        """Find a module that answers SYNC."""
        tester, codec = self.tester, self.setup.codec
        places = {codec.actual_id(axis): axis for axis in codec.axes}
        tester.say(SYNC.identifier)
        found = tester.hear(places, ms(100))
        if found is not None:
            self.setup.module = places[found.identifier]
        self.assumed.append(f"module {self.setup.module}: {'the first that answers' if found is not None else 'none answers'}")

    def _has_parameters(self) -> bool:
        if not self.pics["may_store"]:
            return False
        with suppress(Ended):
            self.tester.ask(56, 0)
        if self.tester.answers:  # its purposes judge the faults of the answer
            return True
        self.assumed.append("no parameters: a request was not answered")
        return False

    # ---- for the runner
    def self_check(self) -> Mapping[str, object]:
        tester = self.tester
        jitter = self._opened.witness.late() if self._opened.witness is not None else 0
        took: float | None = None
        with suppress(Ended):
            tester.turn()
            took = round(tester.answered_after / 1e6, 3)
        return {"clock": tester.clock, "echo": False, "latency_ms": took, "jitter_ms": round((jitter + tester.wire.late_ns) / 1e6, 3)}

    def begin(self, clean: bool) -> None:
        if not clean:
            with suppress(Ended):
                self.tester.rest()
        if self._opened.witness is not None:
            self._opened.witness.begin()
        self.tester.begin()

    def alive(self) -> None:
        self.tester.alive()

    def now(self) -> Ns:
        return self.tester.now()

    def close(self) -> None:
        with suppress(OSError, Ended):
            self.tester.rest()
        self.tester.drop()


def _codec(opened: Opened) -> Codec:
    name = opened.bench.link.get("layout")
    path = Path(find_config("servodyn_gc.dbc", "drives")) if not isinstance(name, str) else (opened.bench.folder / name).resolve()
    try:
        return load_servodyn(path)
    except (OSError, DecodeError, EncodeError, ValueError) as error:
        raise BadFile([f"link.layout {path}: cannot be read ({error}); a DBC file with SYNC, SET_n and ACT_n expected"]) from error
