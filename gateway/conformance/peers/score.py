"""Plays a suite against its faulty devices: each must be killed by an expected FAIL, and no correct variant may FAIL."""

import importlib
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

from drivers.ports.base import PortError
from gateway.conformance.framework.base import Tester
from gateway.conformance.framework.bench_file import Bench
from gateway.conformance.framework.machine import AnyGuarded, Guarded, GuardedFrames
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner
from gateway.conformance.peers.stations import Mutant, Variant
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.registry import Suite
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.conformance.purpose import Purpose, selected
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Machine

Json = dict[str, object]
OBJECTS = frozenset(((0x607A, 0), (0x60FF, 0), (0x6071, 0)))
TOUCH = {"db": (10,), "holding": tuple(range(120)), "coils": tuple(range(120))}


@dataclass(frozen=True, slots=True)
class Killed:
    """Result of one mutant."""

    mutant: Mutant
    fails: tuple[str, ...]

    @property
    def by(self) -> tuple[str, ...]:
        """Expected FAILs only."""
        return tuple(one for one in self.fails if one in self.mutant.expects)


def peers(suite: Suite) -> tuple[Sequence[Mutant], Sequence[Variant]]:
    module = importlib.import_module(suite.peers)
    return module.MUTANTS, module.VARIANTS


def play(suite: Suite, device: Mutant | Variant, only: Sequence[str] = (), seed: int | None = None) -> list[Result]:
    """The suite, or a part of it with its preambles, against one device in virtual time."""
    touch = TOUCH if not isinstance(device, Variant) or device.touch else {}
    written = OBJECTS if not isinstance(device, Variant) or device.touch else frozenset()
    bench = Bench(None, f"machine:{device.id}", link=device.link, touch=touch, objects=written)

    def no_port(url: str, line_format: str) -> ToolPort:
        raise PortError(0, url)

    def make() -> AnyGuarded:
        made = device.make()
        return GuardedFrames(made, device.id) if suite.frames else Guarded(cast(Machine[object], made), device.id)

    opened = Opened(bench, device.pics, no_port, make=make)
    session = suite.session(opened)
    try:
        purposes = suite.purposes()
        chosen = with_preambles(purposes, only) if only else purposes
        return Runner(session, chosen, seed).run()
    finally:
        session.close()


def with_preambles(purposes: Sequence[Purpose[Tester]], only: Sequence[str]) -> list[Purpose[Tester]]:
    """Those named and all they start from."""
    wanted = {purpose.id for purpose in selected(purposes, only)}
    while more := {before for purpose in purposes if purpose.id in wanted for before in purpose.preamble} - wanted:
        wanted |= more
    return [purpose for purpose in purposes if purpose.id in wanted]


def fails(results: Sequence[Result]) -> tuple[str, ...]:
    return tuple(result.purpose.id for result in results if result.verdict is Verdict.FAIL)


def score(suite: Suite, progress: Callable[[str], None] = lambda text: None) -> Json:
    """For `axisgate conformance mutants SUITE --json`."""
    mutants, variants = peers(suite)
    killed = []
    for mutant in mutants:
        one = Killed(mutant, fails(play(suite, mutant)))
        killed.append(one)
        progress(f"{'killed' if one.by else 'ALIVE':8} {mutant.id}: {', '.join(one.fails) or 'no FAIL'}")
    good = {}
    for variant in variants:
        good[variant.id] = fails(play(suite, variant))
        progress(f"{'FAIL' if good[variant.id] else 'good':8} {variant.id}: {', '.join(good[variant.id]) or variant.what}")
    counts = [len(one.fails) for one in killed]
    return {
        "kind": "axisgate conformance mutants",
        "format": 1,
        "suite": {"name": suite.name, "version": suite.version},
        "killed": sum(bool(one.by) for one in killed),
        "mutants": [
            {
                "id": one.mutant.id,
                "what": one.mutant.what,
                "expects": list(one.mutant.expects),
                "killed_by": list(one.by),
                "fails": list(one.fails),
            }
            for one in killed
        ],
        "variants": [{"id": variant.id, "what": variant.what, "fails": list(good[variant.id])} for variant in variants],
        "fails_per_mutant": {"median": statistics.median(counts), "most": max(counts)},
    }
