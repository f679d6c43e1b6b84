"""Builds the parts in C with the system's compiler: `python -m gateway.cycle.native.build`.

Exit code 0: all are built; 1: not all, and the Python twins run (a line names the missing ones).
"""

import os
import pathlib
import shlex
import subprocess
import sys
import sysconfig

from gateway.cycle.native.built import FOLDER, PARTS, library

# No contracted multiplications: the sums must be those of Python, bit by bit
FLAGS = ("-O2", "-Wall", "-Wextra", "-Wno-unused-parameter", "-ffp-contract=off", "-fPIC", "-shared")


def build(part: str, compiler: list[str]) -> str:
    """Build; return the fault, empty on success."""
    target = library(part)
    if target.exists():
        return ""
    fresh = target.with_name(f"{part}-{os.getpid()}.tmp")
    headers = ("-isystem", sysconfig.get_path("include"))
    command = [*compiler, *FLAGS, *headers, str(FOLDER / f"{part}.c"), "-o", str(fresh), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        return f"{compiler[0]}: {error.strerror}"
    if done.returncode:
        fresh.unlink(missing_ok=True)
        return done.stderr.strip() or f"{compiler[0]} ended with {done.returncode}"
    print(done.stderr, end="", file=sys.stderr)
    forget(part, target)
    fresh.rename(target)  # replace it in one step: a cycle may be starting
    return ""


def forget(part: str, but: pathlib.Path) -> None:
    """Libraries of older sources."""
    for old in FOLDER.glob(f"{part}-*{sysconfig.get_config_var('EXT_SUFFIX')}"):
        if old != but:
            old.unlink(missing_ok=True)


def main() -> int:
    compiler = shlex.split(os.environ.get("CC", "cc"))
    faults = {part: fault for part in PARTS if (fault := build(part, compiler))}
    for part, fault in faults.items():
        print(f"native: {part} was not built, its Python twin runs: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
