"""Write a commented cell file from a few questions; it passes check and runs with run --sim."""

import argparse
import contextlib
import json
import os
import pathlib
import sys

from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.runtime.exit_codes import Exit
from gateway.tools.new_cell.cell_text import cell_text
from gateway.tools.new_cell.questions import QUESTIONS, BadAnswer, Question, answered
from gateway.tools.usage_language import complain, result_text

EXAMPLES = """examples:
  axisgate new --from s5-rk512 hall3.toml                        asks five questions, Enter accepts the value in brackets
  axisgate new --from rho3 line2.toml --answer axes=6 --defaults asks nothing
  axisgate new --from modbus saw.toml --answer bind=10.0.0.20:502 --answer plc=10.0.0.5 --json
exit code: 0 written, 2 an answer is not usable, or the file exists already, 3 it cannot be written"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate new", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", metavar="FILE", type=pathlib.Path, help="cell file to write; never overwritten")
    parser.add_argument("--from", dest="kind", choices=tuple(QUESTIONS), required=True, help="the controller that is installed today")
    parser.add_argument("--answer", metavar="KEY=VALUE", action="append", default=[], help="answer a question in advance")
    parser.add_argument("--defaults", action="store_true", help="ask no questions; use the defaults, except for --answer")
    parser.add_argument("--language", choices=LANGUAGES, help="of the cell; else the system's")
    parser.add_argument("--json", action="store_true", help="file and answers as JSON")
    options = parser.parse_args(argv)
    try:
        answers = answered(options.kind, given(options.answer), default if options.defaults else ask)
        text = cell_text(options.kind, answers, options.language or language_of(None, os.environ))
        with options.file.open("x", encoding="utf-8") as out:
            out.write(text)
    except BadAnswer as error:
        complain("new", f"{error}; nothing was written")
        return Exit.INVALID
    except FileExistsError:
        complain("new", f"{options.file} exists already and is not changed; name another file")
        return Exit.INVALID
    except OSError as error:
        complain("new", f"{options.file}: {error.strerror}; nothing was written")
        return Exit.ENVIRONMENT
    if options.json:
        print(json.dumps({"file": str(options.file), "from": options.kind, "answers": answers}))
    else:
        file = options.file
        print(result_text(f"{file} written.  next: axisgate check {file}      then: axisgate run {file} --sim"))
    return Exit.OK


def given(pairs: list[str]) -> dict[str, str]:
    """KEY=VALUE pairs; raises BadAnswer."""
    for pair in pairs:
        if "=" not in pair:
            raise BadAnswer(f"--answer {pair}: KEY=VALUE is needed")
    return {key.strip(): value for key, _, value in (pair.partition("=") for pair in pairs)}


def default(question: Question) -> str:
    """No questions."""
    return question.default


def ask(question: Question) -> str:
    """Ask on the terminal until the answer is valid; from a pipe one answer per line, defaults after its end."""
    while True:
        answer = ""
        with contextlib.suppress(EOFError):
            answer = input(f"{question.text} [{question.default}] ")
        if not sys.stdin.isatty():
            return answer
        try:
            question.check((answer or question.default).strip())
        except ValueError as error:
            print(f"  {answer}: {error}")
            continue
        return answer
