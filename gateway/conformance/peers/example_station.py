"""Example peers of `axisgate conformance`: stations as byte machines, tested in virtual time (see docs/guide/conformance.md)."""

from collections.abc import Callable

from gateway.conformance.peers.can_devices import Drive
from gateway.conformance.peers.interop import Gap
from gateway.conformance.peers.modbus_answers import padded, rewritten
from gateway.conformance.peers.modbus_devices import Answer, Device
from gateway.conformance.peers.stations import ActiveStation, Built
from gateway.conformance.serial.partners import DropsItsJob, Late, NoNak, Silent
from protocols.base.machine import ms
from protocols.p3964r.profiles import PROFILES, Priority

FAULTS: dict[str, Answer] = {"padding": rewritten(1, padded)}


def station(kind: str = "good", profile: str = "rho3", priority: str = "low") -> object:
    """good, active, silent, no-nak, drops-its-job, slow, pause: `machine:example_station.py:station?kind=no-nak`."""
    table, rank = PROFILES[profile], Priority[priority.upper()]
    makers: dict[str, Callable[[], object]] = {
        "good": lambda: Built(table, rank),
        "active": lambda: ActiveStation(table, rank),
        "silent": lambda: Silent(table, rank),
        "no-nak": lambda: NoNak(table, rank),
        "drops-its-job": lambda: DropsItsJob(table, rank),
        "slow": lambda: Late(table, rank, late=ms(3000)),
        "pause": lambda: Gap(table, ms(150)),
    }
    if kind not in makers:
        raise ValueError(f"kind {kind}: there are {', '.join(makers)}")
    return makers[kind]()


def server(rtu: str = "no", kind: str = "good") -> Device:
    """A Modbus server; kind padding: unused bits are 1, one bad server to try a report with."""
    wrong = FAULTS.get(kind)
    if wrong is None and kind != "good":
        raise ValueError(f"kind {kind}: there are good, {', '.join(FAULTS)}")
    return Device(rtu == "yes", wrong)


def booster(kind: str = "good") -> object:
    """A SERVODYN booster, module 1; kind: an id of `axisgate conformance mutants servodyn`, such as half-way."""
    from gateway.conformance.peers import servodyn
    from gateway.conformance.peers.boosters import Booster

    makers: dict[str, Callable[[], object]] = {mutant.id: mutant.make for mutant in servodyn.MUTANTS} | {"good": Booster}
    if kind not in makers:
        raise ValueError(f"kind {kind}: there are {', '.join(makers)}")
    return makers[kind]()


def drive(kind: str = "good") -> object:
    """A CiA 402 drive, node 1; kind: an id of `axisgate conformance mutants canopen-301` or `cia402`, such as no-sync."""
    from gateway.conformance.peers import canopen301, cia402

    makers = {mutant.id: mutant.make for mutant in (*canopen301.MUTANTS, *cia402.MUTANTS)} | {"good": Drive}
    if kind not in makers:
        raise ValueError(f"kind {kind}: there are {', '.join(makers)}")
    return makers[kind]()
