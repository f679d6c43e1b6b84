"""docs/proof.md, and the line of the README that says the same: which rows are proved through what, and the verdicts of the mutants."""

import collections
import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence

from hil_tests.matrix import reach, spelled
from hil_tests.matrix.catalogue import ROOT, Row, rows
from hil_tests.matrix.small import KINDS
from hil_tests.matrix.verdicts import Pair

PAGE = ROOT / "docs" / "proof.md"
README = ROOT / "README.md"
STATUS = re.compile(r"<!-- rows -->.*?<!-- /rows -->", re.DOTALL)
GOAL = 0.9  # of the pairs killed without a crash
VERDICTS = ("killed", "alive", "crash", "hang", "not run")

HEAD = """# Proof

Made by `make mutants`; never edited. Which row of the manuals (`docs/requirements`) is proved by which test is printed by
`make coverage-matrix`; this page counts the rows and says whether those tests would notice their functions breaking.
"""
HOW = """
A *pair* is a test and a function named in its mark. The function is broken, the test runs, and only an assertion of the test counts:
an exception that runs through it is a *crash* and proves nothing. Each function is broken in whole (`raise`: it raises; `return`: it
returns the empty value of its annotation) and in up to six small ways that do not raise, on lines the test runs, chosen by a hash of
the place (two where the test starts processes), one after the other until an assertion notices one. A pair is killed when its test
misses the whole function and an assertion notices a small change, where there is one to make. Not every small change matters to the
one test of a pair. The verdicts are kept in `docs/proof.tsv`; each holds as long as its test and its function read the same
([AX-1510](decisions.md#ax-1510)).
"""


def share(pairs: Sequence[Pair]) -> float:
    return sum(pair.killed for pair in pairs) / len(pairs) if pairs else 1.0


def write(pairs: Sequence[Pair], sample: str = "") -> None:
    """`sample`: how the pairs were drawn, when they are not all that are recorded."""
    claims = spelled.claims()
    by_row: dict[str, set[str]] = {name: set() for name in rows()}
    for one in (one for found in claims.values() for one in found):
        for name in one.ids:
            by_row[name].update(one.by)
    reached = {name: reach.reach_of(functions, reach.kinds()) for name, functions in by_row.items()}
    every = {(test, by) for test, found in claims.items() for one in found for by in one.by}
    pairs = [pair for pair in pairs if (pair.test, pair.by) in every]
    PAGE.write_text("".join(page(rows(), reached, pairs, len(every), sample)), encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    README.write_text(STATUS.sub(lambda _match: f"<!-- rows -->{status(reached)}<!-- /rows -->", text), encoding="utf-8")


def status(reached: Mapping[str, str]) -> str:
    """One sentence."""
    count = counted(reached)
    cell, program, command, api = (count[kind] for kind in reach.KINDS)
    return (
        f"Of {len(reached)} rows of the manuals {cell + program + command} are proved on what a user reaches ({cell} in a cell, "
        f"{program} by a motion program, {command} by a command), {api} on functions of the API that nothing else uses, "
        f"{count['open']} {'is' if count['open'] == 1 else 'are'} open"
    )


def counted(reached: Mapping[str, str]) -> collections.Counter[str]:
    return collections.Counter(kind.partition(" (")[0] or "open" for kind in reached.values())


def page(known: Mapping[str, Row], reached: Mapping[str, str], pairs: Sequence[Pair], every: int, sample: str) -> Iterator[str]:
    yield f"{HEAD}\n## Rows\n\n{status(reached)}.\n\n| list | rows | {' | '.join(reach.KINDS)} | open |\n|---|---|{'---|' * 5}\n"
    for source in dict.fromkeys(row.source for row in known.values()):
        count = counted({name: reached[name] for name, row in known.items() if row.source == source})
        yield f"| {source} | {count.total()} | {' | '.join(str(count[kind]) for kind in reach.KINDS)} | {count['open']} |\n"
    only = [name for name, kind in reached.items() if kind == reach.KINDS[-1]]
    yield f"\nAPI only: {', '.join(only) or 'none'}.\n"
    yield f"\n## Mutants\n{HOW}\n{_extent(pairs, every, sample)}\n\n"
    yield from _table(("pairs", *VERDICTS), [[len(pairs), *_counts(pair.verdict for pair in pairs)]])
    yield f"\n{share(pairs):.0%} of them killed without a crash; goal {GOAL:.0%}.\n\n"
    yield from _table(("mutant", "tried", *VERDICTS), _by_kind(pairs))
    yield from _functions(pairs)
    yield from _left(pairs)


def _extent(pairs: Sequence[Pair], every: int, sample: str) -> str:
    today = time.strftime("%Y-%m-%d")
    if sample:
        return f"**A sample**: {sample}, {len(pairs)} of {every} pairs of the tree, judged {today}."
    whole = "All" if len(pairs) >= every else "**Not all**:"
    return f"{whole} {len(pairs)} of {every} pairs, each judged since its test or function last changed; written {today}."


def _counts(verdicts: Iterable[str]) -> list[int]:
    count = collections.Counter(verdict if verdict in VERDICTS else "not run" for verdict in verdicts)
    return [count[verdict] for verdict in VERDICTS]


def _by_kind(pairs: Sequence[Pair]) -> Iterator[list[object]]:
    tried: dict[str, list[str]] = {"raise": [pair.raised for pair in pairs], "return": [pair.returned for pair in pairs]}
    for kind in KINDS:
        tried[kind] = [trial.verdict for pair in pairs for trial in pair.small if trial.kind == kind]
    for kind, verdicts in tried.items():
        yield [kind, len(verdicts), *_counts(verdicts)]


def _functions(pairs: Sequence[Pair]) -> Iterator[str]:
    """Small mutants, each once: whether any of the tests that name the function noticed."""
    noticed: dict[tuple[str, str], bool] = {}
    for pair in pairs:
        for trial in pair.small:
            noticed[pair.by, trial.name] = noticed.get((pair.by, trial.name), False) or trial.verdict == "killed"
    functions, seen = len({pair.by for pair in pairs}), sum(noticed.values())
    yield f"\nOf {len(noticed)} different small mutants tried of {functions} functions {seen} are noticed by an assertion of some test.\n"


def _left(pairs: Sequence[Pair]) -> Iterator[str]:
    left = sorted((pair.test.partition("::")[2], pair.by, pair.verdict) for pair in pairs if not pair.killed)
    if left:
        yield "\n## Pairs not killed\n\n"
        yield from _table(("test", "function", "verdict"), [[f"`{test}`", f"`{by}`", verdict] for test, by, verdict in left])


def _table(head: Sequence[str], lines: Iterable[Sequence[object]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |\n|{'---|' * len(head)}\n"
    yield from (f"| {' | '.join(map(str, line))} |\n" for line in lines)
