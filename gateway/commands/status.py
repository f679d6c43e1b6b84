"""Show the processes of a run: state, restarts, life counters, and why a process is down."""

import argparse
import json

from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING
from gateway.tools.runs import Row, alarms, chosen, processes, runs

EXAMPLES = """examples:
  axisgate status                   the run that is active on this computer
  axisgate status hall3             this one
  axisgate status hall3 --json      for scripts
exit code: 0 everything is up, 1 a process is not up or an alarm is pending, 3 no such run"""


def main(argv: list[str]) -> int:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("axisgate status", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    parser.add_argument("run", nargs="?", metavar="RUN", help="name of the run (default: the only one)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    run = chosen("status", arguments.run)
    if run is None:
        return ENVIRONMENT
    status = runs().get(run)
    if status is None:
        return ENVIRONMENT
    print(json.dumps(status, indent=1) if arguments.json else text(run, status))
    return DONE if all(row["state"] == "up" for row in processes(status)) and not alarms(status) else FINDING


def text(run: str, status: Row) -> str:
    """A line for the run, one for each process, one for each alarm."""
    kind = "simulated" if status.get("simulated") else "on the machine"
    lines = [f"{run}: {status.get('cell')} ({kind}, clock {status.get('p5_ms')} ms), {status.get('file')}"]
    for row in processes(status):
        life = "" if row["life_age_ms"] is None else f"   sign of life {row['life_age_ms']} ms ago"
        pid = f"pid {row['pid']}" if row["pid"] else "no process"
        lines.append(f"  {row['name']:<20} {row['state']:<8} {pid:<12} {row['restarts']} restarts{life}")
    lines += [f"  alarm: {words}; next: axisgate release {run}" for words in alarms(status)]
    return "\n".join(lines)
