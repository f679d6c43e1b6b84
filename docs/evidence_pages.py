"""Tables of evidence out of configs/evidence.toml: eight rows in README.md, every function in docs/compatibility.md."""

import pathlib
import re
import tomllib

from gateway.files.find import read_evidence

ROOT = pathlib.Path(__file__).resolve().parents[1]
TABLE = re.compile(r"\| what works \| evidence \| not shown yet \|\n\|---\|---\|---\|\n(?:\|.*\n)*")
LEVELS = ("specified", "emulator", "bench", "plant")
HEAD = """# What axisgate replaces, with evidence

Made by `make docs` from `configs/evidence.toml`; the page shows the same levels for the parts of a running cell.

| level | means |
|---|---|
| specified | written from a manual or standard and tested against its text |
| emulator | ran against axisgate's own emulator or partner |
| bench | ran against third-party hardware or software on a bench |
| plant | ran in production |

> "Replaces" means: takes over the listed functions, to the listed evidence level. Functions not listed are absent. Keep the old
> controller, its memory card and its backups; a tested way back belongs to the job.

"""


def table() -> str:
    """The eight rows of the README."""
    rows = tomllib.loads((ROOT / "configs" / "evidence.toml").read_text(encoding="utf-8"))["summary"]
    lines = "".join(f"| {row['what']} | {row['evidence']} | {row['open']} |\n" for row in rows)
    return f"| what works | evidence | not shown yet |\n|---|---|---|\n{lines}"


def readme() -> str:
    """README with its table made anew; ValueError where it has none."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    if not TABLE.search(text):
        raise ValueError("README.md: no table | what works | evidence | not shown yet |")
    made = table()
    return TABLE.sub(lambda found: made, text, count=1)


def page() -> str:
    """docs/compatibility.md: first what was proved furthest."""
    rows = sorted(read_evidence(), key=lambda row: -LEVELS.index(str(row["level"])))
    lines = "".join(f"| {row['what']} | {row['level']} | {row['evidence']} | {row['by']} |\n" for row in rows)
    body = f"| function | level | evidence | judged by |\n|---|---|---|---|\n{lines}"
    return HEAD + body.replace("](docs/", "](")
