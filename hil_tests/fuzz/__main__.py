"""`python -m hil_tests.fuzz [--seed N] [--seconds S] [--only NAME] [--replay ROUND]`: bad input for every machine that listens to a
partner.

Each round follows from its name alone; a find prints the name, and --replay repeats that round only.
Exit code: 0 nothing found, 1 a find.
"""

import argparse
import time
import traceback

from hil_tests.fuzz.player import play
from hil_tests.fuzz.targets import TARGETS

MOST_FINDS = 5


def main(argv: list[str] | None = None) -> int:
    """All targets in turn until the time is over."""
    parser = argparse.ArgumentParser(prog="make fuzz FUZZ=...", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120.0, help="of all targets together (default 120)")
    parser.add_argument("--only", default="", help="targets whose name begins so: modbus, 3964r, rk512")
    parser.add_argument("--replay", metavar="ROUND", help='"modbus.tcp/1/17": one round again')
    arguments = parser.parse_args(argv)
    targets = [target for target in TARGETS if target.name.startswith((arguments.replay or arguments.only).partition("/")[0])]
    if not targets:
        parser.error(f"no such target; there is {', '.join(target.name for target in TARGETS)}")
    if arguments.replay:
        play(targets[0], arguments.replay)
        return 0
    return fuzz(arguments.seed, arguments.seconds, [target.name for target in targets])


def fuzz(seed: int, seconds: float, names: list[str]) -> int:
    """1 when something was found."""
    targets = [target for target in TARGETS if target.name in names]
    rounds, finds, end = 0, 0, time.monotonic() + seconds
    while finds < MOST_FINDS and time.monotonic() < end:
        for target in targets:
            try:
                play(target, f"{target.name}/{seed}/{rounds}")
            except AssertionError:
                traceback.print_exc()
                finds += 1
        rounds += 1
    print(f"seed {seed}: {rounds} rounds of {len(targets)} machines, {finds} finds")
    return 1 if finds else 0


if __name__ == "__main__":
    raise SystemExit(main())
