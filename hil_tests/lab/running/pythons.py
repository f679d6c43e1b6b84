"""The Pythons of this machine that the README promises, except for the one that runs; `python -m hil_tests.lab.running.pythons` prepares
them.

One of the same minor version runs on the packages of this environment, whose compiled parts fit it; any other needs its own, in build.
"""

import json
import os
import pathlib
import subprocess
import sys
from dataclasses import dataclass
from functools import cache

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = ROOT / "build"
FOLDERS = ("/usr/bin", "/usr/local/bin")  # beside PATH: a login may hide Debian's own behind another one
OLDEST = (3, 11)
NAMES = ("python3", *(f"python3.{minor}" for minor in range(OLDEST[1], OLDEST[1] + 8)))
ASKED = "import json, sys; i = sys.implementation; print(json.dumps([sys.version, list(sys.version_info[:3]), i.cache_tag, i.name]))"
PACKAGES = ("pytest", "pytest-asyncio", "pytest-timeout", "hypothesis")
ANSWERS_S = 20.0


@dataclass(frozen=True, slots=True)
class Other:
    """An interpreter that is not the running one."""

    path: str
    version: str  # 3.11.2
    tag: str  # cpython-311: what compiled packages fit

    @property
    def borrows(self) -> bool:
        """Whether this environment's packages serve it."""
        return self.tag == sys.implementation.cache_tag

    @property
    def python(self) -> str:
        """What is started."""
        return self.path if self.borrows else str(BUILD / f"python-{self.tag}" / "bin" / "python")

    @property
    def surroundings(self) -> dict[str, str]:
        """Environment of its processes."""
        plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "AXISGATE_", "PYTEST_"))}
        packages = next(each for each in sys.path if each.endswith("site-packages"))
        return plain | {"PYTHONPATH": os.pathsep.join([str(ROOT), *([packages] if self.borrows else [])])}


@cache
def others() -> tuple[Other, ...]:
    """One of each version."""
    found: dict[str, Other] = {}
    for folder in dict.fromkeys((*FOLDERS, *os.environ.get("PATH", "").split(os.pathsep))):
        for name in NAMES:
            said = _asked(pathlib.Path(folder) / name)
            if said is not None and said[0] != sys.version:
                found.setdefault(said[0], Other(str(pathlib.Path(folder) / name), ".".join(map(str, said[1])), said[2]))
    return tuple(sorted(found.values(), key=lambda each: each.version))


def missing() -> str | None:
    """Why they cannot all be tried, in one line."""
    without = [each.version for each in others() if not pathlib.Path(each.python).exists()]
    return f"no packages for Python {', '.join(without)} (make pythons)" if without else None


def _asked(path: pathlib.Path) -> tuple[str, list[int], str] | None:
    if not os.access(path, os.X_OK):
        return None
    try:
        run = subprocess.run([str(path), "-I", "-c", ASKED], capture_output=True, text=True, timeout=ANSWERS_S, check=True)
        version, numbers, tag, kind = json.loads(run.stdout)
    except (OSError, ValueError, subprocess.SubprocessError):
        return None  # a shim in front of nothing
    return (version, numbers, tag) if kind == "cpython" and tuple(numbers[:2]) >= OLDEST else None


def prepare() -> int:
    """Environments for those that need one."""
    failed = 0
    for each in others():
        folder = BUILD / f"python-{each.tag}"
        if each.borrows or pathlib.Path(each.python).exists():
            continue
        print(f"pythons: installing axisgate's packages for Python {each.version} into {folder.relative_to(ROOT)}", flush=True)
        installs = ["install", "--quiet", "--disable-pip-version-check", "--editable", str(ROOT), *PACKAGES]
        made = subprocess.run([each.path, "-m", "venv", str(folder)], check=False).returncode == 0
        if not made or subprocess.run([each.python, "-m", "pip", *installs], check=False).returncode:
            pathlib.Path(each.python).unlink(missing_ok=True)
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(prepare())
