"""Stop a run in order, as Ctrl-C does: every process ends; drives that are on stop by their own supervision."""

import argparse

from drivers.ports.base import PortError
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING
from gateway.tools.runs import asked, chosen, ended
from gateway.tools.usage_language import complain

ENDS_S = 30.0
EXAMPLES = """examples:
  axisgate stop                     the run that is active on this computer
  axisgate stop hall3               this one
  axisgate stop hall3 && axisgate run hall3.toml    a fresh start
exit code: 0 it has ended, 1 it is still ending after 30 s, 3 no such run"""


def main(argv: list[str]) -> int:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("axisgate stop", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    parser.add_argument("run", nargs="?", metavar="RUN", help="name of the run (default: the only one)")
    run = chosen("stop", parser.parse_args(argv).run)
    if run is None:
        return ENVIRONMENT
    try:
        asked(run, "stop")
    except PortError as error:
        complain("stop", error)
        return ENVIRONMENT
    if not ended(run, ENDS_S):
        complain("stop", f"run {run!r} has not ended within {ENDS_S:g} s; see its processes: axisgate status {run}")
        return FINDING
    print(f"run {run!r} has ended")
    return DONE
