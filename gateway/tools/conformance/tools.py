"""The smaller tools of `axisgate conformance`: list, new-pics, new, mutants, compare, verify."""

import argparse
import json
import re
import sys

from gateway.conformance.peers.score import score
from gateway.conformance.reporting.folder import compare, is_worse, load, suite_of, verify, version_of
from gateway.conformance.reporting.german import verdict_text
from gateway.conformance.suites.opening import Opened, factory_of
from gateway.conformance.suites.registry import SUITES, Suite
from gateway.conformance.suites.scores import SCORES
from gateway.pure.conformance.purpose import GROUPS
from gateway.tools.conformance.run import Stop, bench_of, ending_like_ctrl_c, language, port_opener, started, suite_named, witnessed
from gateway.tools.usage_language import complain

DONE, FINDING = 0, 1
YES, NO = ("y", "yes", "j", "ja", "true", "1"), ("n", "no", "nein", "false", "0")
ID = re.compile(r"^[0-9A-Z]+_[A-Z]+_(BV|BI|BO|TI|CA|RC|ST)_\d{2}$")


def list_suites(arguments: argparse.Namespace) -> int:
    de = language(arguments) == "de"
    if arguments.suite is None:
        for suite in SUITES.values():
            killed, mutants = SCORES[suite.name]
            title = suite.title_de if de else suite.title
            print(f"{suite.name:12} {suite.version}  {len(suite.purposes()):3} cases, {killed} of {mutants} mutants  {title}")
        return DONE
    suite = suite_named(arguments.suite)
    if arguments.json:
        print(json.dumps([_fields(suite, at) for at in range(len(suite.purposes()))], ensure_ascii=False))
        return DONE
    for purpose in suite.purposes():
        print(f"{purpose.id:22} {purpose.role:9} {purpose.summary_de if de else purpose.summary}  [{purpose.clause}]")
    return DONE


def _fields(suite: Suite, at: int) -> dict[str, object]:
    purpose = suite.purposes()[at]
    return {
        "id": purpose.id,
        "group": purpose.group,
        "role": purpose.role,
        "summary": purpose.summary,
        "summary_de": purpose.summary_de,
        "clause": purpose.clause,
        "requirements": list(purpose.requirements),
        "cross_reference": purpose.cross_reference,
        "condition": list(purpose.condition),
        "preamble": list(purpose.preamble),
        "limits": purpose.limits,
    }


def new_pics(arguments: argparse.Namespace) -> int:
    """Ask the device first, then the user, if there is one, for what it cannot report."""
    suite = suite_named(arguments.suite)
    if arguments.output is not None and arguments.output.exists():
        raise Stop(f"--output {arguments.output}: this file exists, and what was entered in it would be lost; name another file")
    found, assumed = _from_device(suite, arguments) if arguments.bench or arguments.port else ({}, [])
    lines = [f"# PICS for the suite {suite.name} {suite.version}", *(f"# {text}" for text in assumed), "[pics]"]
    ask = sys.stdin.isatty()
    for question in suite.questions:
        text = question.text_de if language(arguments) == "de" else question.text
        value = found.get(question.key)
        if value is None and ask and question.kind != "table":
            value = _answer(text, question.kind)
        shown = _toml(value)
        lines.append(f"{question.key} = {shown}  # {text}" if shown else f"# {question.key} =   # {text}")
    content = "\n".join(lines) + "\n"
    if arguments.output is None:
        print(content, end="")
    else:
        arguments.output.write_text(content, encoding="utf-8")
        print(f"{arguments.output}: next: axisgate conformance run {suite.name} --pics {arguments.output} ...")
    return DONE


def _from_device(suite: Suite, arguments: argparse.Namespace) -> tuple[dict[str, object], list[str]]:
    bench = bench_of(arguments)
    make = factory_of(bench, suite.frames, suite.sim)
    with ending_like_ctrl_c(), started(bench), witnessed(make is not None) as witness:
        session = suite.session(Opened(bench, dict(bench.pics), port_opener(bench), make, witness))
        try:
            found = dict(session.discover())
        finally:
            session.close()
    return found, session.assumed


def _answer(text: str, kind: str) -> object:
    """None: not stated, or no more input.  The question is on standard error: standard output may be the file."""
    while True:
        print(f"{text} [{'y/n' if kind == 'bool' else kind}, empty: not stated] ", end="", file=sys.stderr, flush=True)
        said = sys.stdin.readline().strip().lower()
        if not said or kind == "text":
            return said or None
        if kind == "bool" and said in YES + NO:
            return said in YES
        if kind == "whole" and said.isdecimal():
            return int(said)


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else ""


SKELETON = '''@{collector}.case(
    "{short}",
    "what the device must do, in one sentence",
    "dasselbe auf Deutsch",
    clause="where it is written",
    requirements=(),  # ids of docs/requirements/*.csv
    condition=(),  # keys of the PICS that must be true
)
def {name}(t: {tester}) -> None:
    """{group}."""
    with t.given():
        ...  # steps that lead to the question: what fails here is INCONC
    raise NotImplementedError("the question itself: end quietly for PASS, raise Fail(reason, expected, got)")
'''


def new_case(arguments: argparse.Namespace) -> int:
    suite = suite_named(arguments.suite)
    prefixes = sorted({purpose.id.rsplit("_", 2)[0] for purpose in suite.purposes()})
    if not ID.match(arguments.id) or arguments.id.rsplit("_", 2)[0] not in prefixes:
        raise Stop(f"id {arguments.id}: one of {', '.join(prefixes)}, then _{'|'.join(GROUPS)}_NN expected, such as {prefixes[0]}_BV_90")
    if arguments.id in {purpose.id for purpose in suite.purposes()}:
        raise Stop(f"id {arguments.id}: is taken; axisgate conformance list {suite.name}")
    prefix, group, number = arguments.id.rsplit("_", 2)
    tester = "NodeTester" if suite.frames else "ModbusTester" if suite.name.startswith("modbus") else "LineTester"
    print(f"# into gateway/conformance/suites/, next to the other {prefix} cases; a mutant that it kills: gateway/conformance/peers/")
    print(
        SKELETON.format(
            collector=prefix.rsplit("_", 1)[1],
            short=f"{group}_{number}",
            name=f"{group.lower()}_{number}",
            tester=tester,
            group=GROUPS[group].capitalize(),
        ),
        end="",
    )
    return DONE


def play_mutants(arguments: argparse.Namespace) -> int:
    suite = suite_named(arguments.suite)
    stream = sys.stderr if arguments.json else sys.stdout
    found = score(suite, lambda text: print(text, file=stream, flush=True))
    mutants, variants = found["mutants"], found["variants"]
    assert isinstance(mutants, list) and isinstance(variants, list)
    if arguments.json:
        print(json.dumps(found))
    bad = [variant["id"] for variant in variants if variant["fails"]]
    print(
        f"{found['killed']} of {len(mutants)} mutants killed, {len(variants) - len(bad)} of {len(variants)} correct variants without FAIL",
        file=stream,
    )
    return DONE if found["killed"] == len(mutants) and not bad else FINDING


def compare_reports(arguments: argparse.Namespace) -> int:
    """Exit 1 where a verdict became worse."""
    old, new = load(arguments.a), load(arguments.b)
    if suite_of(old) != suite_of(new):
        raise Stop(f"{arguments.a} is a report of the suite {suite_of(old)}, {arguments.b} of {suite_of(new)}: nothing can be compared")
    if version_of(old) != version_of(new):
        notice = f"{arguments.a} is of version {version_of(old)} of the suite, {arguments.b} of {version_of(new)}: cases may have changed"
        complain("conformance", notice)
    rows = compare(old, new)
    if arguments.json:
        print(json.dumps([{"id": name, "before": before, "now": now} for name, before, now in rows]))
    else:
        said = language(arguments)
        alone = [(before, now) for _, before, now in rows if "-" in (before, now) and not is_worse(before, now)]
        rows = [row for row in rows if row[1:] not in alone]
        for name, before, now in rows:
            worse = f" {verdict_text('worse', said)}" if is_worse(before, now) else ""
            print(f"{name:22} {before:7} -> {now:7}{worse}".rstrip())
        differ = "1 verdict differs" if len(rows) == 1 else f"{len(rows)} verdicts differ"
        print(verdict_text(differ if rows else "all verdicts are the same", said))
        for path, count in ((arguments.a, sum(now == "-" for _, now in alone)), (arguments.b, sum(before == "-" for before, _ in alone))):
            if count:
                print(verdict_text(f"only in {path}: {count} of the cases", said))
    return FINDING if any(is_worse(before, now) for _, before, now in rows) else DONE


def verify_folder(arguments: argparse.Namespace) -> int:
    faults = verify(arguments.folder)
    if arguments.json:
        print(json.dumps({"folder": str(arguments.folder), "faults": faults}))
        return FINDING if faults else DONE
    for fault in faults:
        print(f"{arguments.folder}: {verdict_text(fault, language(arguments))}")
    if not faults:
        print(f"{arguments.folder}: {verdict_text('no byte was changed', language(arguments))}")
    return FINDING if faults else DONE
