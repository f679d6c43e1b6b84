"""`python -m hil_tests.soak [TELEGRAMS]`: the soak, with its figures; exit code 1 when anything detectable was wrong or lost."""

import sys
import time

from hil_tests.soak.exhaustive import exhaust
from hil_tests.soak.pairs import Tally, soak


def report(tally: Tally) -> list[str]:
    """The figures in words."""
    return [
        f"{tally.telegrams} telegrams, {tally.faulted} of them faulted, {tally.jobs} RK512 jobs ({tally.reported} failed and reported)",
        "faults: " + ", ".join(f"{kind} {count}" for kind, count in sorted(tally.faults.items())),
        f"detectable: {len(tally.wrong)} delivered wrong, {len(tally.lost)} lost without report",
        f"undetectable at the link: {tally.link_missed} blocks delivered wrong, {tally.link_ack} acknowledgements that were none "
        f"(theory for faults at random: {tally.link_random:.0f}; zero-rich blocks lie more often, the check cannot see a 00h)",
        f"undetectable at RK512: {tally.rk512_missed} jobs with wrong data; {tally.repeats} blocks came twice",
    ]


def main() -> int:
    telegrams = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    start = time.monotonic()
    tally = soak(telegrams, progress=True)
    for line in [*report(tally), *tally.wrong[:20], *tally.lost[:20]]:
        print(line)
    whole = exhaust(stride=1)
    print(f"every single fault: {whole.cases} cases, {len(whole.bad)} bad; undetectable at the link {whole.link}, at RK512 {whole.rk512}")
    print(f"{time.monotonic() - start:.0f} s")
    return 1 if tally.wrong or tally.lost or whole.bad or tally.faulted < tally.telegrams / 10 else 0


if __name__ == "__main__":
    sys.exit(main())
