"""Plays the purposes of a suite at a device: order, preambles, repeats, deaths of the device, Ctrl-C; every case gets its verdict."""

import random
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from drivers.ports.base import PortError
from gateway.conformance.framework.base import Notes, Tester
from gateway.conformance.framework.bench_file import Waiver
from gateway.conformance.framework.causes import name_causes
from gateway.conformance.framework.result import Result
from gateway.pure.conformance.interval import Measure
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import BenchFault, Disturbed, Ended, Inconclusive, Uncertain, Verdict, worst
from protocols.base.machine import Ns, ms

TRIES = 3  # of a case that was disturbed, or whose time lies across a limit
FAR_TOO_LATE = ms(150)  # nothing is known of what happened in that time
MANY_TRIES = 4  # of a host that is late count as one
ASKED = 2  # times whether the device is usable
STUMBLES = 3  # cases in a run that have a second try after a preparing step that failed at a device that works
TOO_LATE = ms(40)  # the same for effects of a time-out: as far as the cases stay away from limits
OF_TIMES = frozenset(("", "nothing", "silence", "no answer", "NAK (15h)", "STX (02h)"))
LATE = ms(10)  # this host was delayed so long: a FAIL proves nothing


class Session(Protocol):
    """A suite at a device: interface for the runner."""

    tester: Tester
    assumed: list[str]  # assumed or discovered facts, in words

    def discover(self) -> Mapping[str, object]: ...  # the PICS, completed; called once before the first case
    def self_check(self) -> Mapping[str, object]: ...
    def begin(self, clean: bool) -> None: ...  # before each try of a case: the line becomes idle; clean: the last case passed
    def alive(self) -> None: ...  # the postamble; an Ended explains a failure
    def now(self) -> Ns: ...
    def close(self) -> None: ...


class Runner:
    """One run.  `progress` gets every result at once."""

    def __init__(
        self,
        session: Session,
        purposes: Sequence[Purpose[Tester]],
        seed: int | None = None,
        waivers: Mapping[str, Waiver] | None = None,
        progress: Callable[[Result], None] = lambda result: None,
    ) -> None:
        self.session, self._waivers, self._progress = session, waivers or {}, progress
        self._order = ordered(purposes, seed)
        self._purposes = list(purposes)
        self.results: dict[str, Result] = {}
        self._gone = ""
        self._gone_in = ""  # the case
        self._worked = False  # the postamble has passed, and not failed since
        self._unusable = ""  # the case that left the device so
        self._clean = False
        self._vain = 0.0  # tries to find it usable again
        self._stumbles = 0
        self.interrupted = False
        self.pics: Mapping[str, object] = {}

    def run(self) -> list[Result]:
        """Results in the order of the suite, whatever the order of the run."""
        try:
            if not self.interrupted:
                self._play()
        except KeyboardInterrupt:
            self.interrupted = True
        for purpose in self._order:
            if purpose.id not in self.results:
                self._keep(Result(purpose, Verdict.INCONC, "not run: the run was interrupted", "the end of the run", "Ctrl-C"))
        name_causes(self.results, self._order)
        return [self.results[purpose.id] for purpose in self._purposes]

    def _play(self) -> None:
        self.pics = self._discovered()
        for purpose in self._order:
            self._keep(self._case(purpose))

    def _discovered(self) -> Mapping[str, object]:
        try:
            return self.session.discover()
        except PortError as error:
            self._gone = _words(error)
            return {}

    def _keep(self, result: Result) -> None:
        result.waived = self._waivers.get(result.purpose.id)
        self.results[result.purpose.id] = result
        self._progress(result)

    def _case(self, purpose: Purpose[Tester]) -> Result:
        missing = [key for key in purpose.condition if not self.pics.get(key)] if not self._gone else []
        if missing:
            return Result(purpose, Verdict.NA, f"the PICS has no {', '.join(missing)}")
        if self._gone:
            return self._without_device(purpose)
        for before in purpose.preamble:
            failed = self.results.get(before)
            if failed is not None and failed.verdict in (Verdict.FAIL, Verdict.INCONC, Verdict.ERROR) and not failed.uncertain:
                root = self.results.get(failed.caused_by, failed) if failed.verdict is Verdict.INCONC else failed
                reason = f"not run: the preamble needs {root.purpose.id}, which is {root.verdict.value} ({root.reason})"
                return Result(purpose, Verdict.INCONC, reason, root.expected, root.got, root.purpose.id)
        return self._left_behind(purpose) or self._repeated(purpose)

    def _left_behind(self, purpose: Purpose[Tester]) -> Result | None:
        """Since that case the device has not been usable: no verdict is possible here."""
        if not self._unusable:
            return None
        if self._vain < TRIES:
            if self._usable() or self._revived():
                self._unusable, self._vain = "", 0
                return None
            self._vain += 1 if self.session.tester.late() <= LATE else 1 / MANY_TRIES
        reason = f"not run: the device has not been usable since {self._unusable}"
        return Result(purpose, Verdict.INCONC, reason, "a device that answers", "no answer", self._unusable)

    def _usable(self) -> bool:
        """Whether the postamble passes; two attempts for a busy device, more if this host was late."""
        vain = 0.0
        while vain < ASKED:
            try:
                self.session.alive()
            except Ended:
                vain += 1 if self.session.tester.late() <= LATE else 1 / ASKED
            else:
                self._worked = True
                return True
        return False

    def _revived(self) -> bool:
        """By its supply, where the bench can switch it."""
        supply = self.session.tester.supply
        if supply is None:
            return False
        try:
            supply.cycle()
            until = self.session.now() + supply.back
            while not self._usable():
                if self.session.now() > until:
                    return False
                supply.pause(ms(200))
        except (Ended, PortError):
            return False
        return True

    def _without_device(self, purpose: Purpose[Tester]) -> Result:
        """The first one is the finding, all others follow from it."""
        expected = "an open port"
        if not self._gone_in:
            self._gone_in = purpose.id
            return Result(purpose, Verdict.FAIL, f"the device was lost: {self._gone}", expected, self._gone)
        return Result(purpose, Verdict.INCONC, f"not run: the device was lost ({self._gone})", expected, self._gone, self._gone_in)

    def _repeated(self, purpose: Purpose[Tester]) -> Result:
        shown: list[str] = []
        stumbled = ""
        seen: list[str] = []
        measures: list[Measure] = []
        for attempt in range(TRIES):
            result, again = self._once(purpose)
            again = again or (attempt == 0 and self._worth_another(result))
            result.notes.measures[:0] = measures
            seen.append(f"{result.behind}|{result.got}" if result.behind else "")
            if not again or attempt == TRIES - 1:
                if shown and again:
                    self._late_thrice(result, seen)
                if stumbled and result.verdict is Verdict.PASS:
                    self._set(result, Verdict.WARN, f"passed when it was repeated; try 1: {stumbled}", "", "")
                result.notes.remarks += shown
                return result
            if result.open_cause and result.late <= LATE:
                stumbled = stumbled or result.reason
            shown.append(f"try {attempt + 1}: {result.reason}")
            measures = list(result.notes.measures)
        raise AssertionError("no try was made")

    @staticmethod
    def _late_thrice(result: Result, seen: Sequence[str]) -> None:
        """A host that is a little late does not cause the same wrong answer each time; silence, a refusal and a repeat can result from
        time-outs on either side, so they need less.
        """
        limit = TOO_LATE if result.got in OF_TIMES else FAR_TOO_LATE
        if result.behind and len(set(seen)) == 1 and result.late < limit:
            result.verdict, result.reason = Verdict.FAIL, result.behind
            result.notes.remarks.append(f"this host was late in each of {TRIES} tries; each brought the same answer")
            return
        result.verdict = Verdict.INCONC

    def _once(self, purpose: Purpose[Tester]) -> tuple[Result, bool]:
        """One try; True: it should be repeated."""
        tester = self.session.tester
        tester.notes, tester.case = Notes(), purpose.id
        start = self.session.now()
        result = Result(purpose, Verdict.PASS)
        again = False
        try:
            self.session.begin(self._clean)
            tester.notes = Notes()
            start = self.session.now()
            again = self._played(purpose, result)
        except PortError as error:
            self._gone, self._gone_in = _words(error), purpose.id
            self._set(result, Verdict.FAIL, f"the device failed in this case: {self._gone}", "a device that answers", _last(tester.notes))
        except Ended as ended:  # the line did not become idle
            again = isinstance(ended, Disturbed)
            self._end(result, ended)
        except (KeyboardInterrupt, SystemExit):
            self._set(result, Verdict.INCONC, "the run was interrupted in this case", "the end of the case", "Ctrl-C")
            result.notes = tester.notes
            self._keep(result)
            raise
        except Exception as error:  # of the tester itself: the other cases are still worth something
            self._set(result, Verdict.ERROR, f"the tester: {type(error).__name__}: {error}", "a verdict", "an error of the tester")
        result.notes, result.late = tester.notes, tester.late()
        result.took = self.session.now() - start
        self._clean = result.verdict is Verdict.PASS
        if result.verdict is Verdict.INCONC and result.open_cause and result.late > LATE:
            again = True  # a step may have failed because this host was late
        if result.verdict is Verdict.FAIL and result.late > LATE and not self._gone:
            result.behind = result.reason
            result.reason = f"this host was {result.late / 1e6:.0f} ms late; seen: {result.reason}"
            result.verdict, again = Verdict.INCONC, True
        return result, again

    def _worth_another(self, result: Result) -> bool:
        """A preparing step failed at a device that works before and after it: a fault that comes now and then hides no other case."""
        stumbled = result.verdict is Verdict.INCONC and result.open_cause
        if not stumbled or not self._worked or not result.purpose.postamble or self._stumbles >= STUMBLES:
            return False
        self._stumbles += 1
        return True

    def _played(self, purpose: Purpose[Tester], result: Result) -> bool:
        try:
            purpose.body(self.session.tester)
            self.session.tester.standing()
        except Ended as ended:
            self._end(result, ended)
            if isinstance(ended, Disturbed):
                return True
        if purpose.postamble and result.verdict is not Verdict.NA:
            self._afterwards(purpose, result)
        return False

    def _afterwards(self, purpose: Purpose[Tester], result: Result) -> None:
        """Each case leaves the device idle and usable; one that was usable before and is not now died in this case."""
        worked = self._worked
        if self._usable() or not worked:
            return
        self._worked, self._unusable, self._vain = False, purpose.id, 0
        if result.verdict is not Verdict.FAIL:
            seen = f"; seen: {result.reason}" if result.reason else ""
            self._set(
                result, Verdict.FAIL, f"the device is unusable after this case{seen}", "a device that answers", result.got or "no answer"
            )
            result.caused_by = ""

    def _end(self, result: Result, ended: Ended) -> None:
        verdict = worst((result.verdict, ended.verdict)) if ended.verdict is not Verdict.NA else Verdict.NA
        self._set(result, verdict, ended.reason, ended.expected, ended.got)
        result.caused_by = ended.caused_by if ended.verdict is Verdict.INCONC else ""
        result.uncertain = isinstance(ended, Uncertain)
        result.open_cause = isinstance(ended, Inconclusive) and not isinstance(ended, (BenchFault, Uncertain)) and not ended.caused_by

    @staticmethod
    def _set(result: Result, verdict: Verdict, reason: str, expected: str, got: str) -> None:
        result.verdict, result.reason = verdict, reason
        result.expected, result.got = (
            expected or ("as stated in the summary" if verdict is Verdict.FAIL else ""),
            got or ("nothing" if verdict is Verdict.FAIL else ""),
        )


def ordered(purposes: Sequence[Purpose[Tester]], seed: int | None) -> list[Purpose[Tester]]:
    """Purposes on which others depend come first, each after those it depends on itself, then early ones; the rest as written, or shuffled;
    those that switch the supply last: a device that loses its settings with it would fail in all others.
    """
    needed = {before for purpose in purposes for before in purpose.preamble}
    known, placed = {purpose.id: purpose for purpose in purposes}, dict[str, Purpose[Tester]]()

    def place(purpose: Purpose[Tester]) -> None:
        for before in purpose.preamble:
            if before in known and before not in placed:
                place(known[before])
        placed[purpose.id] = purpose

    for purpose in purposes:
        if purpose.id in needed and purpose.id not in placed:
            place(purpose)
    first = list(placed.values())
    early = [purpose for purpose in purposes if purpose.id not in needed and purpose.early]
    rest = [purpose for purpose in purposes if purpose.id not in needed and not purpose.early]
    if seed is not None:
        random.Random(seed).shuffle(rest)
    return first + early + sorted(rest, key=lambda purpose: "power" in purpose.condition)


def _words(error: PortError) -> str:
    return str(error.args[-1]) if error.args else "the port was lost"


def _last(notes: Notes) -> str:
    heard = b"".join(piece.data for piece in notes.trace if piece.side == "device")[-16:]
    return f"last received: {heard.hex(' ').upper()}" if heard else "nothing was received in this case"
