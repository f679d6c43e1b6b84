"""Mutants: the body is exchanged in place, for everybody, whatever kind of function it is, and comes back."""

import ast
import asyncio
import dataclasses
import os
import pathlib
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence

import pytest

from gateway.pure.controllers.rho3.functions.display import Display
from hil_tests.matrix import mutants
from hil_tests.matrix.catalogue import ROOT, MarkError, claim, resolve
from hil_tests.matrix.content import fingerprint
from hil_tests.matrix.mutant import MutantError, broken, default_of, mutated
from hil_tests.matrix.mutant_plugin import lines_run
from hil_tests.matrix.small import codes, places, small_mutants
from hil_tests.matrix.verdicts import Pair, Trial, keep_pairs, load_pairs, load_run, save_run
from protocols.base.machine import ms  # an import made before the mutant: it must meet it all the same

MS = "protocols.base.machine:ms"


def test_the_raise_variant_raises_and_afterwards_all_is_as_before() -> None:
    environment = dict(os.environ)
    with mutated(MS, "raise"), pytest.raises(MutantError):
        ms(3)
    assert ms(3) == 3_000_000
    assert dict(os.environ) == environment


def test_the_return_variant_gives_the_empty_value_of_the_annotation() -> None:
    with mutated(MS, "return"):
        assert ms(3) == 0


@pytest.mark.parametrize(("variant", "printed"), [("raise", "MutantError"), ("return", "0")])
def test_a_child_process_meets_the_same_mutant(variant: str, printed: str) -> None:
    script = "from protocols.base.machine import ms\ntry: print(ms(3))\nexcept Exception as error: print(type(error).__name__)"
    with mutated(MS, variant):
        output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert output.strip() == printed


def test_a_child_that_runs_the_module_itself_meets_it_too() -> None:
    """As our processes are started: python -m gateway.processes.NAME."""
    command = [sys.executable, "-m", "gateway.simulation.bus.broker", "--help"]
    with mutated("gateway.simulation.bus.broker:main", "raise"):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "") and "MutantError" in done.stderr
    assert "usage" in subprocess.run(command, capture_output=True, text=True, check=True).stdout


class Sample:
    def method(self) -> bool:
        return True

    def with_super(self) -> str:
        return super().__str__()

    @property
    def shown(self) -> list[int]:
        return [1]

    def words(self) -> Iterator[str]:
        yield "a"

    async def later(self) -> bytes | None:
        return b"a"

    def many(self) -> Sequence[int]:
        return (1,)

    def pair(self) -> tuple[int, int]:
        return (1, 2)

    def either(self) -> int | str:
        return "a"


@pytest.mark.parametrize(
    ("name", "value"),
    [("method", "False"), ("with_super", "''"), ("many", "[]"), ("pair", "()"), ("later", "None"), ("either", "0")],
)
def test_the_default_follows_the_annotation(name: str, value: str) -> None:
    assert default_of(getattr(Sample, name)) == value


RUNS: dict[str, Callable[[Sample], object]] = {
    "with_super": lambda sample: sample.with_super(),
    "words": lambda sample: list(sample.words()),
    "later": lambda sample: asyncio.run(sample.later()),
}


@pytest.mark.parametrize(("name", "empty"), [("with_super", ""), ("words", []), ("later", None)])
def test_methods_that_use_super_generators_and_coroutines_keep_their_kind(name: str, empty: object) -> None:
    function = vars(Sample)[name]
    sound = function.__code__
    try:
        function.__code__ = broken(function, "return")
        assert RUNS[name](Sample()) == empty
        function.__code__ = broken(function, "raise")
        with pytest.raises(MutantError):
            RUNS[name](Sample())
    finally:
        function.__code__ = sound


def test_small_mutants_of_ms_are_these_and_answer_wrongly_without_raising() -> None:
    found = {one.words: one.name for one in small_mutants(MS)}
    assert set(found) == {
        "value * 1000000 -> value / 1000000",
        "1000000 -> 1000001",
        "return round(value * 1000000) -> return round(value * 1000000) + 1",
    }
    answers = {}
    for words, name in found.items():
        with mutated(MS, name):
            answers[words.partition(" ")[0]] = ms(3)
    assert answers == {"value": 0, "1000000": 3_000_003, "return": 3_000_001}
    assert ms(3) == 3_000_000


def test_a_child_process_meets_the_same_small_mutant() -> None:
    name = next(one.name for one in small_mutants(MS) if one.words.startswith("1000000"))
    with mutated(MS, name):
        command = [sys.executable, "-c", "from protocols.base.machine import ms; print(ms(3))"]
        assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == "3000003"


KINDS_IN_SOURCE = """
def f(self, a, b, items, ready):
    if a < b:
        raise ValueError(f"{a + 1}")
    self.count = a + 1
    items.append(a)
    for n in range(b):
        pass
    match a:
        case 1:
            return items[a:b]
    return True and ready
"""


def test_each_kind_of_place_is_found_and_the_words_of_an_exception_are_left() -> None:
    tree = ast.parse(KINDS_IN_SOURCE)
    code = next(one for one in compile(tree, "x", "exec").co_consts if hasattr(one, "co_name"))
    changes = []
    for number, place in enumerate(places(tree, code)):
        changed = ast.parse(KINDS_IN_SOURCE)
        other = list(places(changed, code))[number]
        before = other.words()
        other.change()
        changes.append((place.kind, f"{before} -> {other.words()}"))
    assert set(changes) == {
        ("boundary", "a < b -> a <= b"),
        ("branch", "a < b -> a < b and False"),
        ("statement", "raise ValueError(f'{a + 1}') -> pass"),
        ("statement", "self.count = a + 1 -> pass"),
        ("statement", "items.append(a) -> pass"),
        ("operator", "a + 1 -> a - 1"),
        ("constant", "1 -> 2"),
        ("off-by-one", "range(b) -> range(b + 1)"),
        ("branch", "case 1 -> case 1 if False"),
        ("off-by-one", "a:b -> a + 1:b"),
        ("off-by-one", "a:b -> a:b + 1"),
        ("operator", "True and ready -> True or ready"),
        ("constant", "True -> False"),
    }


INNER_IN_SOURCE = """
def f(a) -> int:
    def act(b) -> str:
        a.append(b)
        return a
    return act
"""


def test_a_function_inside_belongs_to_the_one_that_makes_it() -> None:
    tree = ast.parse(INNER_IN_SOURCE)
    code = next(one for one in compile(tree, "x", "exec").co_consts if hasattr(one, "co_name"))
    found = [(place.kind, place.words()) for place in places(tree, code)]
    assert found == [("off-by-one", "return act"), ("statement", "a.append(b)")], "the answer of the outer is a number, of the inner a text"
    invert = "gateway.pure.languages.robotstar.data_steps:invert"
    with lines_run(dict.fromkeys(codes(resolve(invert).__code__), invert)) as seen:
        assert {one.words for one in small_mutants(invert)} >= {"put(~value) -> pass"} and not seen[invert]


def test_there_are_at_most_six_of_every_kind_in_turn_and_always_the_same() -> None:
    long = "gateway.pure.cycle.core:CycleLogic._drive"
    chosen = small_mutants(long)
    assert len(chosen) == 6 and len({one.name.partition("_")[0] for one in chosen}) >= 3
    fresh = [sys.executable, "-c", f"from hil_tests.matrix.small import small_mutants as s; print([m.name for m in s({long!r})])"]
    assert subprocess.run(fresh, capture_output=True, text=True, check=True).stdout.strip() == str([one.name for one in chosen])


def test_only_what_the_test_runs_is_changed_where_that_is_known() -> None:
    press = "gateway.pure.controllers.rho3.functions.display:Display.press"
    lines = sorted({line for *_, line in resolve(press).__code__.co_lines() if line})
    assert [one.words for one in small_mutants(press, lines=lines[-1:])] == ["self._keys.append(key) -> pass"]
    with lines_run({resolve(press).__code__: press}) as seen:
        Display().press("1")
    assert seen[press] == {lines[1], lines[-1]}, "the key found its place: none is counted as lost"
    assert not any("lost_keys" in one.words for one in small_mutants(press, lines=seen[press]))
    assert any("lost_keys" in one.words for one in small_mutants(press))


@pytest.mark.parametrize(
    "name", ["protocols.base.machine:nothing", "protocols.nowhere:ms", "os:getpid", "protocols.base.machine:Damage", "ms"]
)
def test_what_cannot_be_broken_is_refused_in_words(name: str) -> None:
    with pytest.raises(MarkError, match="by="):
        resolve(name)


@pytest.mark.parametrize(
    ("ids", "by", "words"),
    [
        (("RHO-SER-01", "RHO-SER-02", "RHO-SER-03", "RHO-SER-04"), {"by": MS}, "1..3 ids"),
        ((), {"by": MS}, "1..3 ids"),
        (("RHO-XYZ-01",), {"by": MS}, "RHO-XYZ-01"),
        (("RHO-SER-01",), {}, "by="),
        (("RHO-SER-01",), {"by": MS, "why": "x"}, "nothing else"),
    ],
)
def test_a_mark_that_cannot_be_counted_is_refused_in_words(ids: tuple[str, ...], by: dict[str, object], words: str) -> None:
    with pytest.raises(MarkError, match=words):
        claim(ids, by)


def test_a_mark_may_name_several_functions() -> None:
    assert claim(("RHO-SER-01",), {"by": (MS, MS)}).by == (MS, MS)


def test_a_pair_with_a_verdict_of_its_test_and_function_is_not_judged_again(tmp_path: pathlib.Path) -> None:
    """A whole run takes hours: it goes on where it was interrupted."""
    chosen = "hil_tests/requirements/p3964r/test_block_check_vectors.py"
    first, second, kept = tmp_path / "first.json", tmp_path / "second.json", tmp_path / "kept.tsv"

    def judge(target: pathlib.Path, *known: str) -> str:
        plug_in = ["-p", "hil_tests.matrix.mutant_plugin", "--mutants", str(target), "-p", "no:cacheprovider"]
        command = [sys.executable, "-m", "pytest", chosen, "-q", "-m", "requirement", *plug_in, *known]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT).stdout

    judge(first)
    pairs = load_run(first)
    assert pairs and not any(pair.unjudged for pair in pairs)
    keep_pairs(pairs, kept)
    assert "deselected" in judge(second, "--mutants-known", str(kept)) and not load_run(second)
    keep_pairs(pairs[1:], kept)
    judge(second, "--mutants-known", str(kept))
    assert [(pair.test, pair.by) for pair in load_run(second)] == [(pairs[0].test, pairs[0].by)]


def test_a_verdict_is_kept_in_the_tree_as_it_was_given_and_only_while_test_and_function_read_the_same(tmp_path: pathlib.Path) -> None:
    test, name = "hil_tests/requirements/p3964r/test_block_check_vectors.py", "test_sent"
    trials = (Trial("operator_1a2b3c4d", "alive"), Trial("branch_5e6f7a8b", "killed"))
    pair = Pair(f"{test}::{name}", MS, (), "crash", "killed", fingerprint(ROOT / test, name, MS), trials)
    kept = tmp_path / "kept.tsv"
    keep_pairs([pair, dataclasses.replace(pair, by="protocols.base.machine:gone")], kept)
    assert load_pairs(kept) == [pair]
    keep_pairs([dataclasses.replace(pair, fingerprint="of another text")], kept)
    assert load_pairs(kept) == []
    keep_pairs([dataclasses.replace(pair, raised="not run: sound test: crash")], kept)
    assert kept.read_text() == "", "what could not be judged is tried again"


def test_results_of_an_earlier_run_do_not_replace_verdicts_that_came_into_the_tree_since(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    test, name = "hil_tests/requirements/p3964r/test_block_check_vectors.py", "test_sent"
    pair = Pair(f"{test}::{name}", MS, ("RHO-SER-01",), "crash", "alive", fingerprint(ROOT / test, name, MS), ())
    run = tmp_path / "run.json"
    save_run([pair], run)
    monkeypatch.setattr(mutants, "THIS_RUN", run)
    monkeypatch.setattr(mutants, "GUEST_RESULTS", tmp_path / "none.json")
    written = run.stat().st_mtime_ns
    assert mutants.left_over(written - 1) == mutants.left_over() == [pair]
    assert mutants.left_over(written) == []


TEST = """
import pytest
VALUES = [1, 2]

@pytest.fixture
def made():
    return 3

def helper(): return VALUES

def test_a(made):
    assert helper() == made

def test_b():
    assert 2
"""


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("assert 2", "assert 3", True),
        ("import pytest", "# why\nimport pytest", True),
        ("def helper(): return VALUES", 'def helper():\n    """Whatever it says."""\n    return VALUES', True),
        ("def test_a(made):", 'def test_a(made):\n    """Whatever it says."""', True),
        ("assert helper() == made", "assert helper() != made", False),
        ("[1, 2]", "[1, 3]", False),
        ("return 3", "return 4", False),
    ],
)
def test_a_fingerprint_is_that_of_the_test_and_what_it_uses_of_its_file(tmp_path: pathlib.Path, old: str, new: str, same: bool) -> None:
    first, second = tmp_path / "test_first.py", tmp_path / "test_second.py"
    first.write_text(TEST)
    second.write_text(TEST.replace(old, new))
    assert (fingerprint(first, "test_a", MS) == fingerprint(second, "test_a", MS)) is same
    assert fingerprint(first, "test_a", MS) != fingerprint(first, "test_a", "gateway.pure.controllers.rho3.functions.display:Display.press")
