"""A CANopen node at a bus: its number, its features; before each case it is pre-operational and idle."""

from collections.abc import Callable, Mapping
from contextlib import suppress

from gateway.conformance.framework.bench_file import BadFile, Bench
from gateway.conformance.suites.can.blocks import block_upload
from gateway.conformance.suites.can.node import DEVICE_TYPE, HEARTBEAT, NodeSetup, NodeTester, named
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.supply import frame_supply
from gateway.pure.conformance.verdict import Ended
from protocols.base.machine import Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, nmt, sdo
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.eds import parse
from protocols.canopen.sdo import Request

OBJECTS: dict[str, tuple[tuple[int, int], ...]] = {  # item of the PICS: objects that must be readable
    "heartbeat": (HEARTBEAT,),
    "guarding": ((0x100C, 0), (0x100D, 0)),
    "emcy": ((0x1014, 0),),
    "history": ((0x1003, 0),),
    "consumer": ((0x1016, 1),),
    "store": ((0x1010, 1),),
    "restore": ((0x1011, 1),),
    "sync": ((0x1005, 0),),
    "sync_counter": ((0x1019, 0),),
    "error_behaviour": ((0x1029, 1),),
    "tpdo": ((0x1800, 1), (0x1A00, 0)),
    "rpdo": ((0x1400, 1), (0x1600, 0)),
}
ALL = (
    *OBJECTS,
    "reset",
    "segmented",
    "block",
    "lss",
    "mapping",
    "eds",
    "remote",
    "may_store",
    "may_number",
    "may_move",
    "write_pdo",
    "tpdo_setup",
    "rpdo_setup",
)

TEXTS = ((0x1008, 0), (0x1009, 0), (0x100A, 0), (0x1021, 0), (0x6403, 0), (0x6404, 0), (0x6503, 0), (0x6505, 0))
EXPEDITED = 4  # bytes, at most
MOST_LISTED = 12  # of an EDS are looked at
MOST_BYTES = 2000  # of a block transfer
BOOTS = ms(3000)  # longest time until a device answers for the first time


def read_eds(bench: Bench) -> tuple[ObjectDictionary | None, list[str]]:
    """[link] eds; BadFile where it cannot be read."""
    name = bench.link.get("eds")
    if not isinstance(name, str):
        return None, []
    path = (bench.folder / name).resolve()
    try:
        dictionary, faults = parse(path.read_text(encoding="utf-8", errors="replace"))
    except OSError as error:
        raise BadFile([f"link.eds {path}: cannot be read ({error.strerror or error}); the path begins at the bench file"]) from error
    return dictionary, [str(fault) for fault in faults]


class NodeSession:
    """One run; `look` adds the discovery of a suite on top of CiA 301."""

    def __init__(
        self, opened: Opened, look: Callable[[NodeTester, dict[str, object]], None] | None = None, more: tuple[str, ...] = ()
    ) -> None:
        self._opened, self._look, self._more = opened, look, more
        bench = opened.bench
        self.assumed: list[str] = []
        self.pics: dict[str, object] = dict(opened.pics)
        self.setup = NodeSetup(touch=bench.objects)
        self.setup.dictionary, self._faults = read_eds(bench)
        for name in ("answer", "boot", "cycle"):
            if isinstance(value := bench.link.get(f"{name}_ms"), (int, float)):
                setattr(self.setup, "wait" if name == "answer" else name, ms(value))
        stated = bench.link.get("node", self.pics.get("node"))
        self._node = stated if isinstance(stated, int) else None
        self.setup.node = self._node or 1
        witness = opened.witness
        self.tester = NodeTester(opened.bus, self.setup, witness.late if witness is not None else lambda: 0)

    # ---- features
    def discover(self) -> Mapping[str, object]:
        tester, pics = self.tester, self.pics
        tester.pause(ms(200))
        if self._node is None:
            self._find()
        self.setup.pics = pics
        tester.supply = frame_supply(self._opened, tester)
        pics["power"] = tester.supply is not None
        self.setup.remotes = tester.wire.simulated
        if not self._answers():
            tester.pause(2 * self.setup.wait)  # an answer that comes too late is none to the next request
            self.assumed.append(f"node {self.setup.node} does not answer: it is assumed to offer everything")
            pics |= {item: True for item in (*ALL, *self._more) if item not in pics}
            return pics
        with suppress(Ended):
            tester.command(nmt.Command.PRE_OPERATIONAL)
        for item, keys in OBJECTS.items():
            self._set(item, all(tester.exists(key) for key in keys) if item not in pics else False)
        if pics.get("emcy"):
            with suppress(Ended):
                self.setup.emcy = tester.number((0x1014, 0)) & cobid.ID_BITS
        self._long_object()
        if "lss" not in pics:
            self._set("lss", self._has_lss())
        self._changeable()
        self._derived()
        if self._look is not None:
            self._look(tester, pics)
        return pics

    def _derived(self) -> None:
        """Facts derived from the bench and the port."""
        pics, bench = self.pics, self._opened.bench
        simulated = self.tester.wire.simulated
        pics.setdefault("reset", True)
        pics["eds"] = self.setup.dictionary is not None
        pics["remote"] = self.setup.remotes
        pics["may_store"] = simulated or "store" in bench.allowed
        pics["may_number"] = simulated or "node" in bench.allowed
        pics["may_move"] = simulated or "motion" in bench.allowed
        pics["write_pdo"] = bool(pics.get("rpdo")) and self._may_write()

    def _set(self, item: str, found: bool) -> None:
        if item not in self.pics:
            self.pics[item] = found
            if not found:
                self.assumed.append(f"{item}: not there")

    def _changeable(self) -> None:
        """A small device has PDOs whose parameters, or whose mapping, are fixed: each is written back as it is."""
        tester, pics = self.tester, self.pics
        for item, part in (("tpdo_setup", 0x1800), ("rpdo_setup", 0x1400)):
            self._set(item, bool(pics.get(item[:4])) and self._written_back(part))
        found = False
        if "mapping" not in pics and pics["tpdo_setup"]:
            with suppress(Ended):
                words = [tester.number((0x1A00, sub)) for sub in range(1, tester.number((0x1A00, 0)) + 1)]
                entries = [((0x1A00, sub), word, 4) for sub, word in enumerate(words, 1)]
                found = self._written_back(0x1800, ((0x1A00, 0), 0, 1), *entries, ((0x1A00, 0), len(words), 1))
        self._set("mapping", found)

    def _written_back(self, index: int, *more: tuple[tuple[int, int], int, int]) -> bool:
        """Invalid within the block; False: a part of it was refused."""
        tester, found = self.tester, False
        with suppress(Ended):
            cob, kind = tester.number((index, 1)), tester.number((index, 2))
            try:
                tester.download((index, 1), cob | cobid.INVALID, 4)
                for step in (((index, 2), kind, 1), *more):
                    tester.download(*step)
                found = True
            finally:
                tester.download((index, 1), cob, 4)
        return found

    def _answers(self) -> bool:
        """One that was just switched on may need a moment."""
        until = self.tester.now() + min(self.setup.boot, BOOTS)
        while not (got := self.tester.ask(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))):
            if self.tester.now() > until:
                return False
        self.tester.end_transfer(got)
        return True

    def _find(self) -> None:
        """Without [link] node: who answers?"""
        tester = self.tester
        for node in range(1, cobid.MAX_NODE + 1):
            tester.say_on(cobid.sdo_request(node), sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))
        found = tester.hear(range(0x581, 0x600), self.setup.wait)
        if found is not None:
            self.setup.node = found.identifier - 0x580
        tester.pause(ms(100))
        self.assumed.append(f"node {self.setup.node}: {'the first that answers' if found is not None else 'none answers'}")

    def _long_object(self) -> None:
        """For segmented and block transfers: the first object of more than four bytes, and the longest that is not too long."""
        tester, pics = self.tester, self.pics
        found = {key: size for key in self._perhaps_long() if (size := self._length(key)) > EXPEDITED}
        if found:
            self.setup.text = next(iter(found))
            self.setup.long = max((key for key in found if found[key] <= MOST_BYTES), key=found.__getitem__, default=self.setup.text)
            pics.setdefault("segmented", True)
            self.assumed.append(f"block transfers read {named(self.setup.long)}, {found[self.setup.long]} bytes")
        self._set("segmented", False)
        if "block" not in pics:
            got = tester.ask(block_upload(self.setup.long))
            self._set("block", bool(got) and got[0] >> 5 == sdo.Answer.BLOCK_UPLOAD)
            self._give_up(self.setup.long)

    def _perhaps_long(self) -> list[tuple[int, int]]:
        """Those that CiA 301 and 402 know, then those of the EDS."""
        entries = self.setup.dictionary.entries.values() if self.setup.dictionary is not None else ()
        listed = [entry.key for entry in entries if entry.access.readable and (not entry.type.size or entry.type.size > EXPEDITED)]
        return list(dict.fromkeys((*TEXTS, *[key for key in listed if key not in TEXTS][:MOST_LISTED])))

    def _length(self, key: tuple[int, int]) -> int:
        """Bytes of an upload in segments; one without an announced size is read; 0: there is none."""
        got = self.tester.ask(sdo.initiate(Request.INITIATE_UPLOAD, key))
        if len(got) != 8 or got[0] >> 5 != sdo.Answer.INITIATE_UPLOAD or got[0] & sdo.EXPEDITED:
            return 0
        size = sdo.size_of(got) if got[0] & sdo.SIZED else 0
        self._give_up(key)
        if not size:
            with suppress(Ended):
                size = len(self.tester.upload(key))
        return max(size, EXPEDITED + 1)  # a device that offers it in segments has segments

    def _give_up(self, key: tuple[int, int]) -> None:
        """Ends a transfer begun."""
        self.tester.say(cobid.sdo_request(self.setup.node), sdo.abort(key, sdo.Abort.GENERAL))
        self.tester.pause(ms(20))

    def _has_lss(self) -> bool:
        tester = self.tester
        try:
            address = lss.Identity(*(tester.number((0x1018, sub)) for sub in (1, 2, 3, 4)))
        except Ended:
            return False
        for service, number in zip(range(lss.Service.SELECT_VENDOR, lss.Service.SELECT_SERIAL + 1), address, strict=True):
            tester.say_on(cobid.LSS_MASTER, lss.request(lss.Service(service), number).data)
        found = tester.hear((cobid.LSS_SLAVE,), ms(100)) is not None or self._reports_its_node()
        tester.say(cobid.LSS_MASTER, lss.request(lss.Service.SWITCH_GLOBAL, lss.Mode.WAITING).data)
        return found

    def _reports_its_node(self) -> bool:
        """To LSS, without being selected: it has LSS, whatever identity it knows itself by."""
        tester = self.tester
        tester.say_on(cobid.LSS_MASTER, lss.request(lss.Service.SWITCH_GLOBAL, lss.Mode.CONFIGURATION).data)
        tester.say(cobid.LSS_MASTER, lss.request(lss.Service.INQUIRE_NODE).data)
        found = tester.hear((cobid.LSS_SLAVE,), ms(100))
        return found is not None and found.data[:2] == bytes((lss.Service.INQUIRE_NODE, self.setup.node))

    def _may_write(self) -> bool:
        """Everything the first RPDO carries, but the controlword, may be written."""
        try:
            count = self.tester.number((0x1600, 0))
            words = [self.tester.number((0x1600, sub)) for sub in range(1, count + 1)]
        except Ended:
            return False
        keys = {(word >> 16, word >> 8 & 0xFF) for word in words}
        return bool(keys - {(0x6040, 0)}) and keys - {(0x6040, 0)} <= self.setup.touch

    # ---- for the runner
    def self_check(self) -> Mapping[str, object]:
        wire = self.tester.wire
        start = self.tester.now()
        got = self.tester.ask(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))
        took = self.tester.now() - start
        self.tester.end_transfer(got)
        jitter = self._opened.witness.late() if self._opened.witness is not None else 0
        checked: dict[str, object] = {
            "clock": self.tester.clock,
            "echo": any(frame.identifier == cobid.sdo_request(self.setup.node) for frame in self.tester.heard),
            "latency_ms": round(took / 1e6, 3) if got else None,
            "jitter_ms": round((jitter + wire.late_ns) / 1e6, 3),
        }
        return checked | ({"eds_faults": self._faults} if self._faults else {})

    def begin(self, clean: bool) -> None:
        """Pre-operational and idle; after a case that did not pass the node is reset."""
        tester = self.tester
        if not clean:
            tester.say(cobid.sdo_request(self.setup.node), sdo.abort(DEVICE_TYPE, sdo.Abort.GENERAL))
            if self.pics.get("reset") is not False:
                with suppress(Ended):
                    tester.command(nmt.Command.RESET_NODE)
                    tester.boot_up(min(self.setup.boot, ms(3000)))
                    tester.ready(min(self.setup.boot, BOOTS))
        with suppress(Ended):
            tester.command(nmt.Command.PRE_OPERATIONAL)
        if self._opened.witness is not None:
            self._opened.witness.begin()
        tester.begin()

    def alive(self) -> None:
        self.tester.alive()

    def now(self) -> Ns:
        return self.tester.now()

    def close(self) -> None:
        with suppress(OSError):
            self.tester.command(nmt.Command.PRE_OPERATIONAL)
        self.tester.drop()
