"""`axisgate assess`: ten questions, then whether axisgate can take the old control's place: yes, no, or with what."""

import argparse
import contextlib
import dataclasses
import html
import json
import pathlib
import sys
from collections.abc import Mapping

from gateway.runtime.exit_codes import Exit
from gateway.tools.new_cell.assessment import ASKED, Asked, BadAnswer, Reason, Verdict, assess, verdict

EXAMPLES = """examples:
  axisgate assess                                        asks ten questions
  axisgate assess --html assessment.html                 the same, as a page to print and sign
  axisgate assess --json --answer control=rho3 --answer p15=3 --answer axes=6 --answer drives=servodyn --answer plc=rk512 \\
      --answer pic=no --answer baps=yes --answer backups=printed --answer sister=yes --answer "risk=J. Muster"
exit code: 0 yes, or yes with what is named; 1 no; 2 an answer is missing or none of the question's; 3 the page cannot be written"""
WORDS = {Verdict.YES: "yes", Verdict.WITH: "with", Verdict.NO: "no"}
WHOLE = {
    Verdict.YES: "Yes: axisgate can take over these functions.",
    Verdict.WITH: "With: axisgate can take over, with what stands beside each \"with\".",
    Verdict.NO: "No: not as it stands; what stands beside each \"no\" comes first.",
}  # fmt: skip
LIMITS = (
    '"Replaces" means: takes over the listed functions, to the listed evidence level. Functions not listed are absent. Keep the old'
    " controller, its memory card and its backups; a tested way back belongs to the job. axisgate is not a safety device."
)


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate assess", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--answer", metavar="KEY=VALUE", action="append", default=[], help="answers a question beforehand")
    parser.add_argument("--html", metavar="FILE", type=pathlib.Path, help="the answers as a page to print")
    parser.add_argument("--json", action="store_true", help="verdict and reasons as JSON")
    options = parser.parse_args(argv)
    given = dict(pair.partition("=")[::2] for pair in options.answer)
    unknown = sorted(set(given) - {asked.key for asked in ASKED})
    if unknown:
        print(f"axisgate assess: {', '.join(unknown)}: no such question; {', '.join(asked.key for asked in ASKED)}", file=sys.stderr)
        return Exit.INVALID
    try:
        reasons = assess({asked.key: given[asked.key] if asked.key in given else ask(asked) for asked in ASKED})
        if options.html:
            options.html.write_text(page(reasons), encoding="utf-8")
    except BadAnswer as error:
        print(f"axisgate assess: {error}; give it by --answer {str(error).partition(' ')[0].rstrip(':')}=...", file=sys.stderr)
        return Exit.INVALID
    except OSError as error:
        print(f"axisgate assess: {options.html}: {error.strerror}", file=sys.stderr)
        return Exit.ENVIRONMENT
    print(as_json(reasons) if options.json else "\n".join(table(reasons)))
    return Exit.FINDING if verdict(reasons) is Verdict.NO else Exit.OK


def ask(asked: Asked) -> str:
    """One line of standard input; questions go to standard error, so that --json stays clean."""
    print(f"{asked.text}  [{', '.join(asked.answers) or asked.free}]", file=sys.stderr)
    for word, meaning in asked.answers.items():
        if meaning:
            print(f"    {word:10} {meaning}", file=sys.stderr)
    with contextlib.suppress(EOFError):
        return input().strip()
    return ""


def as_json(reasons: list[Reason]) -> str:
    """Verdict in words and the ten reasons."""
    rows = [{**dataclasses.asdict(reason), "verdict": WORDS[reason.verdict]} for reason in reasons]
    return json.dumps({"verdict": WORDS[verdict(reasons)], "reasons": rows, "limits": LIMITS}, indent=1)


def table(reasons: list[Reason]) -> list[str]:
    """As printed on a terminal."""
    rows = [f"{WORDS[reason.verdict]:5} {reason.key:8} {reason.answer:10} {reason.text}" for reason in reasons]
    return [*rows, "", WHOLE[verdict(reasons)], LIMITS]


def page(reasons: list[Reason]) -> str:
    """One A4 page with room for name and date."""
    questions: Mapping[str, str] = {asked.key: asked.text for asked in ASKED}
    cells = [(questions[reason.key], reason.answer, WORDS[reason.verdict], reason.text) for reason in reasons]
    rows = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in cells)
    return f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>axisgate: assessment</title>
<style>body{{font:14px/1.4 sans-serif;max-width:60em;margin:2em auto;color:#111;background:#fff}}
table{{border-collapse:collapse;width:100%}}td,th{{border:1px solid #666;padding:.3em .5em;text-align:left;vertical-align:top}}
@page{{size:A4;margin:15mm}}</style>
<h1>Can axisgate take this control's place?</h1>
<p><strong>{html.escape(WHOLE[verdict(reasons)])}</strong></p>
<table><tr><th>Question</th><th>Answer</th><th>Verdict</th><th>Reason</th></tr>
{rows}
</table>
<p>{html.escape(LIMITS)}</p>
<p>Name: ______________________ &nbsp; Date: ______________ &nbsp; Signature: ______________________</p>
</html>
"""
