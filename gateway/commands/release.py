"""Restart processes of a run that stay down after too many failures, once the cause is removed."""

import argparse

from drivers.ports.base import PortError
from gateway.tools.command_support import DONE, ENVIRONMENT, USAGE
from gateway.tools.runs import alarms, asked, chosen, processes, runs
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate release hall3            every process that is down or retried at intervals
  axisgate release                  the only run of this computer
  axisgate release hall3 cycle      only this one; its failures are no longer counted
After a start of the cycle the drives are off and nothing moves without a fresh command.
exit code: 0 started or nothing to do, 2 no such process, 3 no such run"""


def main(argv: list[str]) -> int:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("axisgate release", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    parser.add_argument("run", nargs="?", metavar="RUN", help="name of the run (default: the only one)")
    parser.add_argument("process", nargs="?", metavar="PROCESS", help="as axisgate status names it (default: all that need it)")
    arguments = parser.parse_args(argv)
    run = chosen("release", arguments.run)
    status = runs().get(run) if run is not None else None
    if run is None or status is None:
        return ENVIRONMENT
    names = [str(row["name"]) for row in processes(status)]
    if arguments.process is not None and arguments.process not in names:
        complain("release", f"{arguments.process!r}: no such process; run {run!r} has {', '.join(names)}")
        return USAGE
    troubled = {words.partition(" ")[0] for words in alarms(status)} | {str(r["name"]) for r in processes(status) if r["state"] != "up"}
    wanted = [arguments.process] if arguments.process else [name for name in names if name in troubled]
    try:
        for name in wanted:
            asked(run, "release", process=name)
    except PortError as error:
        complain("release", error)
        return ENVIRONMENT
    print(f"run {run!r}: {', '.join(wanted)} released" if wanted else f"run {run!r}: every process is up, nothing to release")
    return DONE
