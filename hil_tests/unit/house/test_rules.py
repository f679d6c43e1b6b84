"""Rules of docs/adding.md that a script can see."""

import ast
import importlib.metadata
import pathlib
import re
import subprocess
import sys
import tomllib

import pytest

from gateway.files.decisions import files as decision_files
from gateway.files.decisions import parsed
from hil_tests.matrix.catalogue import rows
from hil_tests.matrix.spelled import faults_of
from hil_tests.purity import GUARDED_FOLDERS, ROOT

PACKAGES = ("gateway", "drivers", "protocols", "motion", "hil_tests", "configs")
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
IGNORE = re.compile(r"#\s*type:\s*ignore(?P<codes>\[[\w, -]+\])?(?P<reason>.*)$")
MOST_IGNORES = 20
MOST_UNSORTED = 12  # decisions
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def ignores() -> list[tuple[str, "re.Match[str]"]]:
    found = []
    for path in SOURCES:
        if path == pathlib.Path(__file__):
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if match := IGNORE.search(line):
                found.append((f"{path.relative_to(ROOT)}:{number}", match))
    return found


def test_at_most_20_type_ignores_in_all() -> None:
    assert len(ignores()) <= MOST_IGNORES, [where for where, _ in ignores()]


def test_every_type_ignore_names_its_error_and_its_reason() -> None:
    bare = [where for where, match in ignores() if not match["codes"] or len(match["reason"].strip(" #")) < 10]
    assert bare == []


@pytest.mark.parametrize("folder", GUARDED_FOLDERS)
def test_no_sleep_in_tests_of_pure_code(folder: str) -> None:
    sleepers = []
    for path in sorted((ROOT / "hil_tests" / folder).rglob("test_*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("time.sleep", "sleep", "asyncio.sleep"):
                sleepers.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    assert sleepers == []


def test_every_folder_of_tests_is_a_package() -> None:
    bare = {path.parent for path in (ROOT / "hil_tests").rglob("test_*.py") if not (path.parent / "__init__.py").exists()}
    assert bare == set()


def test_all_three_lists_of_requirements_are_there_with_unlike_ids() -> None:
    assert {row.source for row in rows().values()} == {"rho3", "robotstar", "val3"}
    lines = [
        line for path in (ROOT / "docs" / "requirements").glob("*.csv") for line in path.read_text().splitlines()[1:] if line[3:4] == "-"
    ]
    assert len(rows()) == len(lines)


def test_a_mark_of_a_function_that_went_is_reported_without_running_its_test(tmp_path: pathlib.Path) -> None:
    mark = '@pytest.mark.requirement("RHO-MOT-12", by=(HERE + "Trial.skip", HERE + "{}"))\ndef test_it(): ...\n'
    here = 'HERE = "gateway.pure.planning.trial:"\n'
    for name, faults in (("Trial.coming", 0), ("Trial.gone", 1)):
        (tmp_path / "made_up.py").write_text(here + mark.format(name))
        found = list(faults_of(tmp_path / "made_up.py"))
        assert len(found) == faults and all("made_up.py:2: by='gateway.pure.planning.trial:Trial.gone'" in line for line in found)


def test_the_lock_pins_every_requirement_within_its_range() -> None:
    from packaging.requirements import Requirement

    pins = dict(line.split("==") for line in (ROOT / "requirements.lock").read_text().splitlines() if "==" in line)
    asked = [*PROJECT["project"]["dependencies"], *PROJECT["project"]["optional-dependencies"]["test"]]
    for requirement in map(Requirement, asked):
        assert requirement.name in pins, requirement
        assert requirement.specifier.contains(pins[requirement.name]), requirement


def test_the_lock_names_no_place() -> None:
    assert not re.search(r"https?:|@|--", (ROOT / "requirements.lock").read_text())


def test_every_command_of_the_project_file_is_registered() -> None:
    registered = {entry.name: entry.value for entry in importlib.metadata.entry_points(group="axisgate.commands")}
    assert registered == PROJECT["project"]["entry-points"]["axisgate.commands"]


PROHIBITED = re.compile(r"\bsafe\b(?![- ]torque)|\bcertified\b|drop-in|100 ?% compatible|real-time guaranteed", re.IGNORECASE)
ALLOWED_SENTENCES = ("certified hardware", "fail-safe behaviour")


def texts() -> list[pathlib.Path]:
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


@pytest.mark.parametrize("path", texts(), ids=lambda path: str(path.relative_to(ROOT)))
def test_our_texts_promise_nothing_they_must_not(path: pathlib.Path) -> None:
    said = [line for line in path.read_text().splitlines() if PROHIBITED.search(re.sub("|".join(ALLOWED_SENTENCES), "", line))]
    assert said == []


LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")


@pytest.mark.parametrize("path", texts(), ids=lambda path: str(path.relative_to(ROOT)))
def test_every_link_of_our_texts_leads_somewhere(path: pathlib.Path) -> None:
    dead = [target for target in LINK.findall(path.read_text()) if not (path.parent / target).exists()]
    assert dead == []


ANCHORED = re.compile(r"\]\((?!https?:|mailto:)([^)#\s]*)#([^)\s]+)\)")


def anchors(path: pathlib.Path) -> set[str]:
    """Of a page: explicit ones, and those a code host makes of headings."""
    text = path.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {*re.findall(r'<a id="([^"]+)">', text), *(re.sub(r"[^\w -]", "", each.lower()).replace(" ", "-") for each in headings)}


@pytest.mark.parametrize("path", texts(), ids=lambda path: str(path.relative_to(ROOT)))
def test_every_link_to_a_place_in_a_page_lands_there(path: pathlib.Path) -> None:
    """Decisions have the anchor #ax-nnn, wherever their chapter is."""
    dead = [
        (name, place) for name, place in ANCHORED.findall(path.read_text()) if place not in anchors(path.parent / name if name else path)
    ]
    assert dead == []


def test_nearly_every_decision_has_a_chapter_of_the_page() -> None:
    unsorted = [path.name for path in decision_files() if not parsed(path.name, path.read_text(encoding="utf-8")).chapter]
    assert len(unsorted) <= MOST_UNSORTED, unsorted


def test_the_page_of_decisions_says_what_its_files_say() -> None:
    done = subprocess.run([sys.executable, ROOT / "docs" / "assemble.py", "--check"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), "run make docs"


def test_every_decision_that_is_named_exists() -> None:
    known = set(re.findall(r"^### (AX-\d{3,4})", (ROOT / "docs" / "decisions.md").read_text(), re.MULTILINE))
    named = {number for path in SOURCES for number in re.findall(r"\bAX-\d{3,4}\b", path.read_text())}
    assert named - known == set()
