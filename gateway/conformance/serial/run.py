"""Runs the list of serial-protocols 6 against one station and judges it, with reasons and measured times."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gateway.conformance.case import Case
from gateway.conformance.serial import cases_active, cases_receive, cases_rk512, cases_send
from gateway.conformance.serial.bench import TOLERANCE, Bench, Fail, Inconclusive, Notes, NotRun, Stimulus, Verdict
from gateway.conformance.serial.cases_rk512 import Place, header
from gateway.conformance.serial.partners import Station
from gateway.links.serial.tool_wire import VirtualWire, Wire
from gateway.pure.lines.texts import said
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import Priority, Profile

LATE = TOLERANCE // 2  # this program was delayed so long: a FAIL of this test proves nothing


@dataclass(frozen=True, slots=True)
class Settings:
    """Known facts about the station under test."""

    profile: Profile
    priority: Priority  # of the station
    layer: str = "rk512"  # rk512 | raw
    stimulus: str = "auto"  # auto | operator | fetch | none
    active: bool = False  # the station itself sends RK512 commands when stimulated
    place: Place = Place()
    only: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Result:
    """One line of the report."""

    case: Case
    verdict: str
    reason: str
    notes: Notes
    late_ns: Ns
    took_ns: Ns


def all_cases(settings: Settings) -> list[Case]:
    """The list in the order in which it is run."""
    found = cases_receive.IDLE.all + cases_receive.RECEIVE.all + cases_send.SEND.all + cases_send.CONFLICT.all
    if settings.layer == "rk512":
        found = found + cases_rk512.cases(settings.place)
    if settings.active:
        found = found + cases_active.cases(settings.place.reaction)
    if settings.only:
        found = [case for case in found if any(only in (case.name, case.group) for only in settings.only)]
    return found


def unknown(settings: Settings) -> list[str]:
    """Names of `only` that are neither a test nor a group of tests here."""
    names = {name for case in all_cases(replace(settings, only=())) for name in (case.name, case.group)}
    return [name for name in settings.only if name not in names]


def stimulus_of(wire: Wire, settings: Settings, ask_operator: Callable[[], None]) -> Stimulus | None:
    """How this station is made to send."""
    wanted = settings.stimulus
    station = wire.station if isinstance(wire, VirtualWire) else None
    own = station.stimulate if isinstance(station, Station) else None
    if wanted == "auto":
        wanted = "sim" if own is not None else "fetch" if settings.layer == "rk512" else "none"
    if wanted == "sim" and isinstance(wire, VirtualWire) and own is not None:
        act = wire.act
        return Stimulus("the simulated station has a job", lambda bench: act(own))
    if wanted in ("fetch", "sim"):
        place = settings.place
        telegram = header(cases_rk512.FETCH, cases_rk512.TYPE_DB, place.db, place.word, 2)
        return Stimulus("FETCH: the reaction is its block", lambda bench: bench.give_good(telegram, "a FETCH"), place.reaction)
    if wanted == "operator":
        return Stimulus("operator", lambda bench: ask_operator(), ms(30_000))
    return None


def hold_of(wire: Wire) -> Callable[[bool], None] | None:
    """A simulated station can keep its buffer full."""
    station = wire.station if isinstance(wire, VirtualWire) else None
    if not isinstance(wire, VirtualWire) or not isinstance(station, Station):
        return None
    act = wire.act
    return lambda held: act(lambda now: station.hold(held, now))


def probe(
    wire: Wire,
    settings: Settings,
    ask_operator: Callable[[], None] = lambda: None,
    on_result: Callable[[Result], None] = lambda result: None,
) -> list[Result]:
    """Every case once; `on_result` gets each result at once.  PortError when the port goes away."""
    bench = Bench(wire, settings.profile, settings.priority, stimulus_of(wire, settings, ask_operator), hold_of(wire))
    if settings.layer == "rk512":
        bench.harmless = bytes(4)  # an unexpected reaction
    results: list[Result] = []
    for case in all_cases(settings):
        result = run_case(bench, case, clean=not results or results[-1].verdict == "PASS")
        results.append(result)
        on_result(result)
    return results


def run_case(bench: Bench, case: Case, clean: bool = True) -> Result:
    """One case with a quiet line before it; after a case that broke off, a job of the station may still wait for its next attempt."""
    _quiet(bench, None if clean else bench.profile.ack_delay + ms(300))
    bench.notes, bench.wire.late_ns = Notes(), 0
    bench.mark = start = bench.wire.now()
    try:
        case.run(bench)
        verdict, reason = "PASS", ""
    except Verdict as ended:
        verdict, reason = ended.word, ended.args[0]
    late = bench.wire.late_ns
    if late > TOLERANCE or (late > LATE and verdict == Fail.word):
        reason = said("the bench itself was {:.0f} ms late", late / 1e6) + (said("; seen: {}", reason) if reason else "")
        verdict = Inconclusive.word
    return Result(case, verdict, reason, bench.notes, late, bench.wire.now() - start)


def _quiet(bench: Bench, quiet: Ns | None) -> None:
    """Accept what an earlier test left over; a station that never falls silent is still judged."""
    try:
        bench.settle(quiet)
    except Inconclusive:
        bench.pass_time(bench.wire.now() + ms(500))


JUDGED = ("PASS", "FAIL", "WARN")


def exit_code(results: Sequence[Result]) -> int:
    """0: no FAIL; 1: at least one."""
    return int(any(result.verdict == Fail.word for result in results))


def counted(results: Sequence[Result]) -> dict[str, int]:
    """Verdict -> how many."""
    words = ("PASS", "FAIL", "WARN", Inconclusive.word, NotRun.word)
    return {word: sum(result.verdict == word for result in results) for word in words}


def _layers(results: Sequence[Result], settings: Settings) -> str:
    """The layers judged: RK512 only if one of its tests was completed."""
    rk512 = any(result.verdict in JUDGED and result.case.name.startswith(("rk512.", "active.")) for result in results)
    layers = "3964R and RK512" if rk512 else "3964R"
    return layers if settings.profile.block_check else layers.replace("3964R", "3964")


def conclusion(results: Sequence[Result], settings: Settings) -> str:
    """The summary, in one sentence."""
    count = counted(results)
    layers = _layers(results, settings)
    asked = sum(count[word] for word in JUDGED)
    late, left = count[Inconclusive.word], count[NotRun.word]
    if not asked:
        return said("Conclusion: no statement about the station: no test was completed.")
    if not count["PASS"] and asked == 1:
        text = "Conclusion: the station does not speak {} here: the one test did not pass; axisgate line diagnose finds the cause."
        return said(text, layers)
    if not count["PASS"]:
        text = "Conclusion: the station does not speak {} here: none of {} tests passed; axisgate line diagnose finds the cause."
        return said(text, layers, asked)
    if count["FAIL"]:
        first = next(result for result in results if result.verdict == "FAIL")
        text = "Conclusion: the station does not comply with {}: {} of {} tests fail, the first is {} ({})."
        return said(text, layers, count["FAIL"], asked, first.case.name, first.reason)
    if count["WARN"]:
        text = "Conclusion: the station speaks {}; {} of {} tests show a difference that its partner must allow."
        return said(text, layers, count["WARN"], asked)
    if late:
        text = "Conclusion: no test contradicts {}, but {} tests are inconclusive: the bench was late; try again."
        return said(text, layers, late)
    if asked == 1:
        return said("Conclusion: the station speaks {} in the one test that was run.", layers)
    if left:
        return said("Conclusion: the station speaks {} in all {} tests that were run; not run: {}.", layers, asked, left)
    return said("Conclusion: the station speaks {} in all {} tests.", layers, asked)


def stamp() -> str:
    """Moment of a report, local time."""
    return time.strftime("%Y-%m-%d %H:%M:%S")
