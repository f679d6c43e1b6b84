"""`python -m hil_tests.house.words`: forbidden words in texts that a user reads and in public docstrings (make lint).

Read are string literals and public docstrings of product code, texts of the page, configs, the written pages of docs and decisions.
words.toml allows a number of findings for a file.  `--lower` writes what is left there; a number never rises.
"""

import ast
import pathlib
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from hil_tests.house.statements import statements_in

ROOT = pathlib.Path(__file__).resolve().parents[2]
ALLOWED = pathlib.Path(__file__).with_name("words.toml")
PACKAGES = ("gateway", "drivers", "motion", "protocols")
PAGES = ("README.md", "mkdocs.yml", "docs/*.md", "docs/guide/*.md", "docs/howto/*.md", "docs/decisions.d/*.md")
MADE = ("docs/decisions.md", "docs/errors.md", "docs/compatibility.md", "docs/proof.md", "docs/benchmarks.md")  # made of what is read here

INSTEAD = {  # forbidden -> what the field says
    r"told|tells?": "reports, names, distinguishes",
    r"says": "states, contains, reads",
    r"stands|stood": "is, is set, is kept",
    r"whoever": "the client, the user",
    r"nobody(?:'s)?|anybody|everybody|somebody": "no client, any partner, another program",
    r"vouch(?:es)?": "valid",
    r"paper": "dry run",
    r"pictures?": "view, screenshot",
    r"sheets?": "table",
    r"desks?|offices?": "the part by its name",
    r"doors?": "command source",
    r"ours|theirs": "axisgate's",
    r"he|him|himself|his": "the partner, the user",
    r"hands": "passes, gives",
    r"amiss": "wrong, missing",
    r"teased": "under fault injection",
    r"Tuer(?:en)?|Tür(?:en)?": "Befehlsquelle",
}
FORBIDDEN = re.compile(rf"(?<![\w/.-])(?:{'|'.join(INSTEAD)})(?![\w/]|[.-]\w|\(|\s*=)", re.IGNORECASE)
GENUINE = re.compile(  # the field's own use of a word
    r"stands? (?:for|still|alone)|stood still|\d  says\b|guard doors?|data ?sheets?|sheet metal|interpretation paper|"
    r"\"door\": \d|both hands|hands[- ]on|hands up|"
    r"picture (?:book|of)|`[^`\n]+`",
    re.IGNORECASE,
)
QUOTED = re.compile(r'"(?:\\.|[^"\\\n])*"')  # the page's texts are in double quotes, so that they can be translated
KEY = re.compile(r'^\s*(?:(?:[\w-]+|"[^"]*")(?:\.[\w-]+)*\s*=|\[+[^]"]*\]+)', re.MULTILINE)
TAG = re.compile(r"<[^>]*>", re.DOTALL)


class Text(NamedTuple):
    """A passage that is read, with the line on which it begins."""

    line: int
    text: str


class Finding(NamedTuple):
    """A forbidden word in a file."""

    path: str
    line: int
    word: str
    text: str


def python_texts(source: str) -> Iterator[Text]:
    """String literals of more than one word, and docstrings of public names."""
    tree = ast.parse(source)
    docstrings = dict(_docstrings(tree, public=True))
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and docstrings.get(id(node), " " in node.value):
            yield Text(node.lineno, node.value)


def _docstrings(node: ast.AST, public: bool) -> Iterator[tuple[int, bool]]:
    """Identity of each docstring's node, and whether the name that it describes is public."""
    body = getattr(node, "body", None)
    named = isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
    if named and body and isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
        yield id(body[0].value), public
    for child in statements_in(node):
        yield from _docstrings(child, public and not str(getattr(child, "name", "")).startswith("_"))


def script_texts(source: str) -> Iterator[Text]:
    """String literals of more than one word."""
    for found in QUOTED.finditer(source):
        if " " in found[0]:
            yield Text(source.count("\n", 0, found.start()) + 1, found[0])


def line_texts(source: str) -> Iterator[Text]:
    for number, line in enumerate(source.splitlines(), 1):
        yield Text(number, line)


def texts(path: pathlib.Path) -> Iterator[Text]:
    """What a user reads of one file."""
    source = path.read_text(encoding="utf-8")
    match path.suffix:
        case ".py":
            return python_texts(source)
        case ".js":
            return script_texts(source)
        case ".html":
            return line_texts(TAG.sub(lambda found: "\n" * found[0].count("\n"), source))
        case ".toml":
            return line_texts(KEY.sub("", source))
    return line_texts(source)


def files() -> list[pathlib.Path]:
    found = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    found += [path for path in (ROOT / "gateway" / "web").rglob("*") if path.suffix in (".js", ".html")]
    found += [*(ROOT / "configs").rglob("*.toml"), *(path for pattern in PAGES for path in ROOT.glob(pattern))]
    return sorted(path for path in found if str(path.relative_to(ROOT)) not in MADE)


def findings(path: pathlib.Path) -> Iterator[Finding]:
    for number, text in texts(path):
        bare = GENUINE.sub(lambda found: re.sub(r"\S", "_", found[0]), text)
        for found in FORBIDDEN.finditer(bare):
            line = number + bare.count("\n", 0, found.start())
            yield Finding(str(path.relative_to(ROOT)), line, found[0], " ".join(text.splitlines()[line - number].split()))


def allowed() -> dict[str, int]:
    return {name: int(count) for name, count in tomllib.loads(ALLOWED.read_text(encoding="utf-8")).items()}


def judged(found: list[Finding], limits: dict[str, int]) -> list[str]:
    """One line for each finding of a file that has more than it may."""
    counts = Counter(finding.path for finding in found)
    above = {name for name, count in counts.items() if count > limits.get(name, 0)}
    return [f"{one.path}:{one.line}: {one.word!r}: {one.text}" for one in found if one.path in above]


def lowered(found: list[Finding], limits: dict[str, int]) -> dict[str, int]:
    """Limits that are left: what is found, never more than was allowed."""
    counts = Counter(finding.path for finding in found)
    return {name: min(limit, counts[name]) for name, limit in sorted(limits.items()) if counts[name]}


def main() -> int:
    found = [finding for path in files() for finding in findings(path)]
    limits = allowed()
    if "--all" in sys.argv[1:]:
        limits = {}
    if "--lower" in sys.argv[1:]:
        rows = [f'"{name}" = {count}\n' for name, count in lowered(found, limits).items()]
        ALLOWED.write_text(ALLOWED.read_text(encoding="utf-8").partition("\n")[0] + "\n" + "".join(rows), encoding="utf-8")
    faults = judged(found, limits)
    print("\n".join(faults), end="\n" if faults else "")
    print(f"words: {len(found)} forbidden, {sum(limits.values())} allowed in {len(limits)} files")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
