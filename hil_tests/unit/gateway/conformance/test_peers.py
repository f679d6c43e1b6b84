"""Programs at the other end of a port: found by what they hold, and how long they waited for a processor (files as those of proc(5))."""

import pathlib

import pytest

from gateway.conformance.framework.host import Host
from gateway.conformance.framework.peers import EDGE, Peers
from gateway.conformance.peers.stations import Built
from gateway.conformance.suites.line import LineSetup, LineTester
from gateway.links.serial.tool_wire import VirtualWire
from gateway.pure.conformance.verdict import Fail, Uncertain
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import RHO3, Priority

DEVICE, CABLE, BEYOND, OTHER = 41, 42, 43, 44


class Proc:
    """A folder as /proc."""

    def __init__(self, root: pathlib.Path) -> None:
        self.root = root
        (root / "net").mkdir()

    def process(self, pid: int, held: dict[int, tuple[str, str]]) -> None:
        """held: descriptor -> what it is, its details."""
        for folder in ("fd", "fdinfo", f"task/{pid}"):
            (self.root / str(pid) / folder).mkdir(parents=True)
        for number, (link, details) in held.items():
            (self.root / str(pid) / "fd" / str(number)).symlink_to(link)
            (self.root / str(pid) / "fdinfo" / str(number)).write_text(details)
        self.waited(pid, 0)

    def waited(self, pid: int, ns: Ns, state: str = "S") -> None:
        task = self.root / str(pid) / "task" / str(pid)
        (task / "schedstat").write_text(f"1000 {ns} 7\n")
        (task / "stat").write_text(f"{pid} (a (b) c) {state} 1 1\n")


@pytest.fixture
def proc(tmp_path: pathlib.Path) -> Proc:
    return Proc(tmp_path)


def master(number: int) -> tuple[str, str]:
    return "/dev/ptmx", f"pos:\t0\nflags:\t02\ntty-index:\t{number}\n"


def of_device(proc: Proc) -> Peers:
    proc.process(DEVICE, {5: master(7)})
    peers = Peers("pty:/dev/pts/7", proc.root)
    peers.look()
    return peers


def waits_of(proc: Proc, url: str) -> Ns:
    """What the programs found there waited after each one waited its number of milliseconds."""
    peers = Peers(url, proc.root)
    peers.look()
    peers.sample(ms(1))
    for pid in (DEVICE, CABLE, BEYOND, OTHER):
        if (proc.root / str(pid)).exists():
            proc.waited(pid, ms(pid))
    peers.sample(ms(10))
    return peers.within(ms(1))


def test_who_holds_the_other_end_of_a_pty_is_the_device(proc: Proc) -> None:
    proc.process(DEVICE, {5: master(7)})
    proc.process(OTHER, {3: master(8), 4: ("/dev/pts/8", "")})
    assert waits_of(proc, "pty:/dev/pts/7") == ms(DEVICE)


def test_behind_a_cable_the_program_at_its_other_end_counts_too(proc: Proc) -> None:
    proc.process(CABLE, {5: master(7), 6: master(9)})
    proc.process(BEYOND, {3: ("/dev/pts/9", "")})
    proc.process(OTHER, {3: ("/dev/pts/11", "")})
    assert waits_of(proc, "/dev/pts/7") == ms(CABLE + BEYOND)


def test_a_server_of_this_host_is_who_listens(proc: Proc) -> None:
    rows = ("sl local rem st", "0: 0100007F:01F6 0:0 0A 0:0 0:0 0 0 0 55 1", "1: 0100007F:01F6 0100007F:9000 01 0:0 0:0 0 0 0 99 1")
    (proc.root / "net" / "tcp").write_text("\n".join(rows))
    proc.process(DEVICE, {3: ("socket:[55]", "")})
    proc.process(OTHER, {3: ("socket:[99]", "")})
    assert waits_of(proc, "tcp://127.0.0.1:502") == ms(DEVICE)
    assert not _known(Peers("tcp://10.0.0.7:502", proc.root)), "another host"


def _known(peers: Peers) -> bool:
    peers.look()
    return peers.known


def test_a_program_that_was_started_anew_is_looked_for_again(proc: Proc) -> None:
    peers = of_device(proc)
    (proc.root / str(DEVICE)).rename(proc.root / "gone")
    proc.process(OTHER, {3: master(7)})
    peers.look()
    peers.sample(ms(1))
    proc.waited(OTHER, ms(9))
    peers.sample(ms(5))
    assert peers.within(0) == ms(9)


def test_one_that_still_waits_is_late_already(proc: Proc) -> None:
    peers = of_device(proc)
    for now in range(1, 20):
        proc.waited(DEVICE, 0, "S" if now < 5 else "R")
        peers.sample(ms(now))
    assert peers.within(ms(2)) == ms(15), "at 4 ms it was seen asleep for the last time"
    proc.waited(DEVICE, ms(14))
    peers.sample(ms(20))
    assert peers.within(ms(2)) == ms(14), "what the system counted, once"


def test_waits_in_the_midst_of_a_long_span_do_not_move_its_ends(proc: Proc) -> None:
    peers, end = of_device(proc), ms(2000)
    for now, waited in ((0, 0), (ms(50), ms(2)), (ms(150), ms(2)), (ms(1000), ms(300)), (end - EDGE, ms(300)), (end, ms(303))):
        proc.waited(DEVICE, waited)
        peers.sample(now)
    assert (peers.ends(0), peers.within(0)) == (ms(5), ms(303))


class InRealTime(VirtualWire):
    simulated = False


@pytest.mark.parametrize(
    "waits, took, ended",
    [
        ((), ms(600), Fail),
        (((1450, ms(60)),), ms(600), Uncertain),  # at an end: it may have begun so late
        (((1700, ms(60)),), ms(600), Uncertain),  # in between: nothing is said against the device
        (((1700, ms(60)),), ms(550), None),  # and nothing for it
    ],
    ids=["no-wait", "at-its-end", "in-between", "in-between-and-right"],
)
def test_a_time_is_wrong_only_where_no_wait_of_the_device_explains_it(
    proc: Proc, waits: tuple[tuple[int, Ns], ...], took: Ns, ended: type[Exception] | None
) -> None:
    peers = of_device(proc)
    wire = InRealTime(Built(RHO3), ms(1))
    tester = LineTester(wire, LineSetup(RHO3, Priority.LOW), Host(None, peers))
    for step in range(0, 2001, 50):
        proc.waited(DEVICE, sum(ns for at, ns in waits if at <= step))
        peers.sample(ms(step))
    wire._now = tester.mark = ms(2000)

    def judged() -> None:
        tester.timed("STX after silence", took, ms(529), ms(571))

    assert _ended(judged) is ended


def _ended(judged: object) -> type[Exception] | None:
    assert callable(judged)
    try:
        judged()
    except (Fail, Uncertain) as ended:
        return type(ended)
    return None


def test_what_tester_and_device_wait_within_one_step_adds_up(proc: Proc) -> None:
    """A block comes too late for a device when both waited, each for less than its limit."""
    peers = of_device(proc)
    for now, waited, own in ((0, 0, 0), (100, 60, 0), (200, 60, 80), (300, 90, 80), (2000, 150, 80)):
        proc.waited(DEVICE, ms(waited))
        peers.sample(ms(now), ms(own))
    assert peers.worst(0) == ms(140)
    assert peers.worst(ms(1000)) == 0
