"""Assess whether axisgate can replace a controller: ten questions, then yes, no or conditions, with reasons."""

import argparse
import dataclasses
import html
import json
import os
import pathlib
import sys

from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.pure.reports.sentences import in_language
from gateway.runtime.exit_codes import Exit
from gateway.tools.new_cell.assessment import ASKED, TEXTS, Asked, BadAnswer, Reason, Verdict, assess, judge, verdict
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate assess                                        asks ten questions
  axisgate assess --html assessment.html                 the same, as a page to print and sign
  axisgate assess --json --answer control=rho3 --answer p15=3 --answer axes=6 --answer drives=servodyn --answer plc=rk512 \\
      --answer pic=no --answer baps=yes --answer backups=printed --answer sister=yes --answer "risk=J. Muster"
exit code: 0 yes, or yes with what is named; 1 no; 2 an answer is missing or not allowed; 3 the page cannot be written"""
WORDS = {Verdict.YES: "yes", Verdict.WITH: "with", Verdict.NO: "no"}
LINE = 20 * "_"


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate assess", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--answer", metavar="KEY=VALUE", action="append", default=[], help="answer a question in advance")
    parser.add_argument("--html", metavar="FILE", type=pathlib.Path, help="the answers as a page to print")
    parser.add_argument("--json", action="store_true", help="verdict and reasons as JSON")
    parser.add_argument("--language", choices=LANGUAGES, help="language of questions, table and page (default: the system's)")
    options = parser.parse_args(argv)
    language = language_of(options.language, os.environ)
    given = dict(pair.partition("=")[::2] for pair in options.answer)
    unknown = sorted(set(given) - {asked.key for asked in ASKED})
    if unknown:
        complain("assess", f"{', '.join(unknown)}: no such question; {', '.join(asked.key for asked in ASKED)}")
        return Exit.INVALID
    try:
        reasons = assess({asked.key: given[asked.key] if asked.key in given else ask(asked, language) for asked in ASKED})
        if options.html:
            options.html.write_text(page(reasons, language), encoding="utf-8")
    except BadAnswer as error:
        complain("assess", f"{error}; give it by --answer {str(error).partition(' ')[0].rstrip(':')}=...")
        return Exit.INVALID
    except OSError as error:
        complain("assess", f"{options.html}: {error.strerror}")
        return Exit.ENVIRONMENT
    print(as_json(reasons) if options.json else "\n".join(table(reasons, language)))
    return Exit.FINDING if verdict(reasons) is Verdict.NO else Exit.OK


def ask(asked: Asked, language: str = "en") -> str:
    """Read a line of standard input; repeat the question after an invalid answer.  Questions go to standard error, not into --json."""
    print(f"{in_language(asked.text, language)}  [{', '.join(asked.answers) or in_language(asked.free, language)}]", file=sys.stderr)
    for word, meaning in asked.answers.items():
        if meaning:
            print(f"    {word:10} {in_language(meaning, language)}", file=sys.stderr)
    while True:
        try:
            answer = input().strip()
        except EOFError:
            return ""
        try:
            judge(asked, answer)
        except BadAnswer as error:
            print(f"    {error}", file=sys.stderr)
        else:
            return answer


def as_json(reasons: list[Reason]) -> str:
    """Verdict in words and the ten reasons; for programs, in English."""
    rows = [{**dataclasses.asdict(reason), "verdict": WORDS[reason.verdict], "text": str(reason.text)} for reason in reasons]
    return json.dumps({"verdict": WORDS[verdict(reasons)], "reasons": rows, "limits": _in("limits", "en")}, indent=1)


def _in(key: str, language: str) -> str:
    return in_language(TEXTS.said(key), language)


def _answers(reasons: list[Reason], language: str) -> list[tuple[str, str, str, str]]:
    """Key, answer, verdict and reason of each question."""
    return [(each.key, each.answer, _in(WORDS[each.verdict], language), in_language(each.text, language)) for each in reasons]


def table(reasons: list[Reason], language: str = "en") -> list[str]:
    """As printed on a terminal."""
    answers = _answers(reasons, language)
    width = max(5, *(len(judged) for _key, _answer, judged, _text in answers))
    rows = [f"{judged:{width}} {key:8} {answer:10} {text}" for key, answer, judged, text in answers]
    return [*rows, "", _in(f"whole.{WORDS[verdict(reasons)]}", language), _in("limits", language)]


def page(reasons: list[Reason], language: str = "en") -> str:
    """One A4 page with room for name and date."""
    questions = {asked.key: in_language(asked.text, language) for asked in ASKED}
    cells = [(questions[key], *others) for key, *others in _answers(reasons, language)]
    rows = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in cells)
    heads = "".join(f"<th>{_in(f'page.{head}', language)}</th>" for head in ("question", "answer", "verdict", "reason"))
    return f"""<!doctype html>
<html lang="{language}"><meta charset="utf-8"><title>axisgate: assessment</title>
<style>body{{font:14px/1.4 sans-serif;max-width:60em;margin:2em auto;color:#111;background:#fff}}
table{{border-collapse:collapse;width:100%}}td,th{{border:1px solid #666;padding:.3em .5em;text-align:left;vertical-align:top}}
@page{{size:A4;margin:15mm}}</style>
<h1>{html.escape(_in("page.title", language), quote=False)}</h1>
<p><strong>{html.escape(_in(f"whole.{WORDS[verdict(reasons)]}", language))}</strong></p>
<table><tr>{heads}</tr>
{rows}
</table>
<p>{html.escape(_in("limits", language))}</p>
<p>Name: {LINE} &nbsp; {_in("page.date", language)}: {LINE} &nbsp; {_in("page.signature", language)}: {LINE}</p>
</html>
"""
