"""Stations for the suite interop: one with the times of each maker, all of which must understand each other, and faulty ones."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from gateway.conformance.peers.p3964r import MUTANTS as LINK
from gateway.conformance.peers.rk512 import MUTANTS as JOBS
from gateway.conformance.peers.stations import DLE, ActiveStation, AnswersLate, Built, Mutant, Variant, link_of
from gateway.conformance.serial.partners import Late, Station
from gateway.conformance.suites.interop.cases import REFERENCE, case_id
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import PROFILES, RHO3, Priority, Profile
from protocols.rk512.dialects import dialect_of

LOW = Priority.LOW


class Gap(Late):
    """A pause inside each of its blocks, which its own profile allows."""

    def __init__(self, profile: Profile, gap: Ns) -> None:
        super().__init__(profile, LOW, late=gap)

    def _collect(self, now: Ns) -> None:
        output = self.link.take_output()
        cut = 3 if len(output) > 3 else len(output)
        if output:
            self._queue.append((now, output[:cut]))
        if output[cut:]:
            self._queue.append((now + self._late, output[cut:]))


class LateAcknowledgement(AnswersLate):
    """DLE to STX at once, DLE to the block late."""

    _acknowledged = 0

    def _collect(self, now: Ns) -> None:
        output = self.link.take_output()
        if output:
            block = output == DLE and self.counts["BlockReceived"] > self._acknowledged
            self._acknowledged = self.counts["BlockReceived"]
            self._queue.append((now + (self._late if block else 0), output))


def _station(profile: Profile) -> Built:
    """Both roles where its dialect has reactions."""
    if not dialect_of(profile.name).reaction:
        return Built(profile, profile.priority, "raw")
    return ActiveStation(profile, profile.priority)


def _maker(name: str, profile: Profile) -> Variant:
    return Variant(name, f"a station of {name}", lambda: _station(profile), link_of(profile, profile.priority), {})


def _mutant(name: str, what: str, expects: Sequence[str], make: Callable[[], Station]) -> Mutant:
    return Mutant(name, what, tuple(case_id(*one.split()) for one in expects), make, link_of(RHO3, LOW), {})


def _of(mutants: Sequence[Mutant], rows: Mapping[str, str], pics: Mapping[str, object]) -> Iterator[Mutant]:
    """Faulty stations of another suite, and the rows that they cannot play with the first maker."""
    found = {mutant.id: mutant for mutant in mutants}
    for name, expected in rows.items():
        expects = tuple(case_id(REFERENCE, row) for row in expected.split())
        yield replace(found[name], expects=expects, pics={**found[name].pics, **pics})


ON_THE_LINK = {
    "silent": "BV_01",
    "drops-its-job": "BV_04",
    "short-buffer": "BV_03",
    "counts-once": "BV_01",
    "includes-stx": "BV_01",
    "complement": "BV_01",
    "never-doubles": "BV_02",
    "any-check": "BI_02",
    "stx-restarts": "BV_01",
    "nak-ends": "BV_01",
    "any-is-dle": "TI_01",
    "any-acknowledges": "BI_01",
    "nak-acknowledges": "BI_01",
    "silence-acknowledges": "BI_03",
    "no-repeat": "BI_01 BI_03",
    "sends-twice": "BV_02",
    "repeat-differs": "BI_03",
    "without-stx": "BI_01 BI_03",
    "wrong-priority": "BV_04",
    "wrong-priority-2": "BV_04",
    "drops-in-conflict": "BV_04",
    "resets-on-conflict": "BV_04",
    "own-check-wrong": "BV_02",
    "check-without-end": "BV_02",
    "no-check": "BV_02",
    "no-end": "BV_02",
    "check-10h": "BV_11",
}
OF_RK512 = {
    "no-reaction": "BV_11",
    "first-byte": "BV_11",
    "always-error": "BV_11",
    "byte-short": "BV_11",
    "word-more": "BV_11",
    "slow-reaction": "BV_11",
    "data-behind-send": "BV_12",
    "send-refused": "BV_12",
    "not-written": "BV_12",
    "swaps-written": "BV_12",
    "swaps-read": "BV_12",
    "reverse": "BV_12",
    "off-by-one": "BV_12",
    "first-word-only": "BV_12",
    "reaction-twice": "BV_12 BI_11",
    "any-block": "BI_11",
    "data-behind-error": "BI_11",
    "silent-errors": "BI_11",
    "hangs-when-long": "ST_01 BV_13",
}
MUTANTS: tuple[Mutant, ...] = (
    *_of(LINK, ON_THE_LINK, {}),
    *_of(JOBS, OF_RK512, {"rk512": True, "passive": True}),
    _mutant("gap-150ms", "a pause of 150 ms in its block", ["euchner-hbas BV_02"], lambda: Gap(RHO3, ms(150))),
    _mutant("gap-210ms", "a pause of 210 ms in its block", ["vipa-cp240 BV_02", "vipa-21x BV_02"], lambda: Gap(RHO3, ms(210))),
    _mutant("dle-after-520ms", "DLE after 520 ms, later than some wait", ["euchner-hbas BV_01"], lambda: AnswersLate(late=ms(520))),
    _mutant("late-acknowledgement", "takes 1.9 s to judge a block", ["vipa-cp240 BV_01"], lambda: LateAcknowledgement(late=ms(1900))),
    _mutant(
        "two-attempts",
        "gives up after two attempts",
        ["vipa-cp240 TI_01", "vipa-21x TI_01"],
        lambda: Built(replace(RHO3, connect_attempts=2)),
    ),
)
VARIANTS = tuple(_maker(name, profile) for name, profile in PROFILES.items())
