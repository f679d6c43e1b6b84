"""`python -m hil_tests.soak [TELEGRAMS [SEED]]`: the soak, with its figures; exit code 1 when anything detectable was wrong or lost."""

import sys
import time

from hil_tests.soak.conflicts import conflicts
from hil_tests.soak.exhaustive import exhaust
from hil_tests.soak.pairs import Tally, soak

ROUNDS = 1000


def counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(counts.items())) or "none"


def report(tally: Tally, procedure: str, theory: str) -> list[str]:
    """The figures in words."""
    missed, acknowledged = sum(tally.rk512_missed.values()), sum(tally.link_acknowledged.values())
    return [
        f"{procedure}: {tally.telegrams} telegrams, {tally.faulted} of them faulted",
        f"  {tally.jobs} RK512 jobs, {tally.reported} of them reported as failed",
        f"  faults: {counted(tally.faults)}",
        f"  payloads of the jobs: {counted(tally.payloads)}; {counted(tally.roles)}",
        f"  detectable: {len(tally.wrong)} delivered wrong, {len(tally.lost)} lost without report",
        f"  undetectable at the link: {tally.link_missed} blocks delivered wrong ({theory}: {tally.link_random:.0f}), "
        f"{acknowledged} acknowledged that were not taken: {counted(tally.link_acknowledged)}",
        f"  undetectable at RK512: {missed} jobs with wrong data: {counted(tally.rk512_missed)}",
        f"  {tally.repeats} blocks came twice",
        *(f"  for example {why}: {words}" for why, words in sorted(tally.examples.items())),
    ]


def main() -> int:
    telegrams = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    start = time.monotonic()
    checked, plain = soak(telegrams, seed, progress=True)
    print(f"seed {seed}: {checked.telegrams + plain.telegrams} telegrams, {checked.faulted + plain.faulted} of them faulted")
    for line in report(checked, "3964R", "theory for faults at random, 1/256 of the spoiled blocks"):
        print(line)
    for line in report(plain, "3964, no block check", "theory, all spoiled blocks that keep their form; spoiled"):
        print(line)
    wrong = [*checked.wrong, *plain.wrong, *checked.lost, *plain.lost]
    for line in wrong[:20]:
        print(line)
    whole = exhaust(stride=1)
    print(f"every single fault: {whole.cases} cases, {len(whole.bad)} bad; undetectable at the link {whole.link}, at RK512 {whole.rk512}")
    pairs, failed = conflicts(ROUNDS)
    print(f"both send at once: {pairs} pairs of dialects, {ROUNDS} rounds each, {len(failed)} not complete {failed[:5]}")
    print(f"{time.monotonic() - start:.0f} s")
    enough = checked.faulted + plain.faulted >= (checked.telegrams + plain.telegrams) / 10
    return 1 if wrong or whole.bad or failed or not enough else 0


if __name__ == "__main__":
    sys.exit(main())
