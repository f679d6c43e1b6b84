"""Debian's mbpoll as a client we did not write: one poll or one write, and the values it printed."""

import subprocess


def mbpoll(port: int, *options: str, values: tuple[int, ...] = (), unit: int = 1) -> tuple[int, str]:
    """Return the exit code and all output."""
    command = ["mbpoll", "-m", "tcp", "-p", str(port), "-a", str(unit), "-1", "-q", "-o", "5", *options, "127.0.0.1"]
    done = subprocess.run([*command, *map(str, values)], capture_output=True, text=True, timeout=30, check=False)
    return done.returncode, done.stdout + done.stderr


def values_of(text: str) -> dict[int, int]:
    """`[1]:  65535 (-1)` -> {1: 65535}"""
    rows = (line.split(":", 1) for line in text.splitlines() if line.startswith("["))
    return {int(reference[1:-1]): int(value.split()[0]) for reference, value in rows}
