"""Run the demo: two PLCs move six emulated drives; judged by emulator, bus log and line record."""

import argparse
import json
import pathlib
import shutil
import signal
import sys
import tempfile
from collections.abc import Sequence

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.can.open import open_can
from gateway.runtime.realtime import realtime_allowed
from hil_tests import demo_page
from hil_tests.lab.running.awake import awake
from hil_tests.lab.running.scenario import Scenario, ScenarioFailed
from hil_tests.rig.uml import guest

EXAMPLES = """examples:
  axisgate demo                                      on the local bus, P5 = 4 ms
  axisgate demo --seed 7 --keep                      other targets; the records are kept
  axisgate demo --bus socketcan:vcan0 --p5 20        on a SocketCAN interface
  axisgate demo --own-time                           on a busy virtual machine
exit code 4: this machine was too slow for a cycle of 32 ms, by the bus log
"""
SLOW_P5 = 10
SLOWER = (10, 20, 32)
OWN_TIME_RECORDS = guest.ROOT / "build" / "demo"
OWN_TIME_LIMIT_S = 1800.0  # of the host: one minute of the demo takes two to fifteen of a machine that others use
TAKEN_AWAY = "end other programs and try again; axisgate run demo --sim waits for a late machine (docs/guide/tutorial.md, minute 3)"
TOO_SLOW = 4  # exit code: the machine was too slow for all of these


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate demo", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bus", help="CAN port in place of the local bus, e.g. socketcan:vcan0")
    parser.add_argument("--p5", type=int, help="cycle in ms (2..32); default 4, or 10 where real-time priority is refused")
    parser.add_argument("--seed", type=int, default=1, help="of the targets (default 1)")
    parser.add_argument("--keep", action="store_true", help="keep the records and print their folder")
    parser.add_argument("--records", type=pathlib.Path, help="folder for the records (implies --keep)")
    parser.add_argument("--name", default="demo", help="name of the run for `axisgate var` (default demo)")
    parser.add_argument("--modbus-port", type=int, help="TCP port of PLC 2's server (default: the cell's, or a free one)")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    parser.add_argument(
        "--own-time", action="store_true", help="run in a guest with its own clock, which a busy machine cannot make late (make kernel)"
    )
    arguments = parser.parse_args(argv)
    if arguments.own_time:
        return in_own_time(argv, arguments.records or OWN_TIME_RECORDS)
    if arguments.p5 is not None and not 2 <= arguments.p5 <= 32:
        print(f"axisgate demo: --p5 {arguments.p5}: the cycle is 2..32 ms", file=sys.stderr)
        return 2
    if arguments.bus:
        try:
            open_can(arguments.bus).close()
        except PortError as error:  # told at once, not when the run has waited for its drives
            print(f"axisgate demo: {error}", file=sys.stderr)
            return 3
    p5 = arguments.p5 or (4 if realtime_allowed() else SLOW_P5)
    folder = arguments.records or pathlib.Path(tempfile.mkdtemp(prefix="axisgate-demo-"))
    folder.mkdir(parents=True, exist_ok=True)
    for number in (signal.SIGINT, signal.SIGTERM):  # SIGINT too: a shell's background job starts with it ignored
        signal.signal(number, _interrupt)
    if arguments.p5 is None and p5 == SLOW_P5:
        print(f"real-time priority is refused here: P5 = {SLOW_P5} ms instead of 4 ms", file=sys.stderr)
    slower = [each for each in SLOWER if each > p5] if arguments.p5 is None else []
    with awake():
        while True:
            scenario = Scenario(
                folder,
                name=arguments.name,
                seed=arguments.seed,
                p5_ms=p5,
                bus=arguments.bus,
                port=arguments.modbus_port,
                quiet=arguments.json,
            )
            code, late = play(scenario, arguments, last=not slower)
            if not late:
                break
            scenario.say(f"this machine was too slow for P5 = {p5} ms: {late}; the drives stopped, as they must")
            if not slower:
                code = code if arguments.p5 else TOO_SLOW
                scenario.say(TAKEN_AWAY)
                break
            p5 = slower.pop(0)
            scenario.say(f"once more with P5 = {p5} ms\n")
    if not (arguments.keep or arguments.records or code):
        shutil.rmtree(folder, ignore_errors=True)
    else:
        scenario.say(f"records: {folder}")
    return code


def play(scenario: Scenario, arguments: argparse.Namespace, *, last: bool) -> tuple[int, str]:
    """One run of the scenario: exit code, and how the machine, not axisgate, left the drives without SYNC, "" when it did not."""
    try:
        verdicts = scenario.play()
    except KeyboardInterrupt:
        print("\naxisgate demo: stopped; nothing is left running", file=sys.stderr)
        return 1, ""
    except ScenarioFailed as failure:
        print(f"axisgate demo: {failure}", file=sys.stderr)
        return failure.code, failure.late
    finally:
        scenario.close()
    ok = all(verdict.ok for verdict in verdicts)
    late = "" if ok else scenario.machine_late()
    if late and not last:
        return 1, late
    page = (scenario.folder if arguments.keep or arguments.records else runtime_dir()) / "demo.html"
    demo_page.write(page, verdicts)
    scenario.say(f"page with the verdicts, and the paths of a SCARA and a six-axis arm: {page}")
    if arguments.json:
        print(json.dumps([{"name": v.name, "value": v.value, "limit": v.limit, "ok": v.ok} for v in verdicts], indent=1))
    return (0 if ok else 1), late


def in_own_time(argv: Sequence[str], records: pathlib.Path) -> int:
    """The same demo in a guest whose time passes only while everybody in it sleeps (docs/guest.md); its records on the host."""
    if lacking := guest.missing() or (None if guest.own_time() else "its kernel is not built (make kernel)"):
        print(f"axisgate demo: no guest with a clock of its own: {lacking}", file=sys.stderr)
        return 3
    records.mkdir(parents=True, exist_ok=True)
    options = [each for each in argv if each != "--own-time"]
    plain = ["env", "TTY_COMPATIBLE=0", "AXISGATE_RUNTIME=/run/axisgate"]
    command = [*plain, sys.executable, "-m", "gateway", "demo", *options, "--records", str(records.absolute())]
    return guest.Guest(guest.ROOT / "build" / "uml" / "demo-own-time", OWN_TIME_LIMIT_S).run(command, lambda line: print(line, flush=True))


def _interrupt(number: int, frame: object) -> None:
    raise KeyboardInterrupt
