"""Starting a child in the supervisor: its regions, and whether it is a copy of this process or a new Python (AX-1740)."""

import contextlib
import functools
import importlib
import os
import signal
import subprocess
from collections.abc import Iterable, Mapping, Sequence

from gateway.assembly.run import Child
from gateway.runtime.copied import can_copy, command_line, start_copy
from gateway.runtime.life import VARIABLE as LIFE
from gateway.runtime.realtime import die_with_parent, survive_terminal
from gateway.runtime.regions import fds_to_text
from gateway.runtime.spare import OPTION

# An unused pool of threads delays the end of a killed cycle and takes 80 MB (AX-434)
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
SERVICES, CYCLE, PLANNER = "gateway.services.loop", "gateway.cycle.loop", "gateway.processes.planner"
LOADED_TWICE = {SERVICES: SERVICES, PLANNER: CYCLE}  # the spare needs the modules of the services, a planner most of those of the cycle


class Starter:
    """Starts the processes of one run; `fds`: its regions by name, `plan_fd`: the pickled plan."""

    def __init__(self, fds: Mapping[str, int], plan_fd: int, children: Sequence[Child]) -> None:
        self._fds, self._plan_fd = fds, plan_fd
        self._shared = loaded_before(child.module for child in children)

    def start(self, child: Child, *, spare: bool = False, again: bool = False) -> "subprocess.Popen[bytes]":
        """At first a copy of this process, which has most modules loaded; `again`: a new Python (AX-1740).

        OSError, SubprocessError: no memory, no more processes, no program.
        """
        arguments, keep, environment = self._given(child)
        arguments += [OPTION] if spare else []
        stdin = subprocess.PIPE if spare else subprocess.DEVNULL
        first = functools.partial(_ready_to_run, os.getpid())
        if not again and can_copy():
            self._load_shared(child)
            return start_copy(child.module, arguments, stdin=stdin, keep=keep, environment=environment, first=first)
        return subprocess.Popen(
            command_line(child.module, arguments),
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=keep,
            env=os.environ | environment,
            start_new_session=True,
            preexec_fn=first,  # noqa: PLW1509 there is no thread here
        )

    def _load_shared(self, child: Child) -> None:
        """Only when needed: emulated drives lock all memory there is, and a cycle needs nothing of the services."""
        if child.module in self._shared:
            with contextlib.suppress(Exception):  # the child meets the fault itself, and its words go to the journal
                importlib.import_module(child.module)

    def _given(self, child: Child) -> tuple[list[str], list[int], dict[str, str]]:
        """Its arguments, the inherited files, and the additions to its environment."""
        fds = {name: self._fds[name] for name in child.regions}
        arguments, keep, environment = [*child.arguments], list(fds.values()), dict(ONE_THREAD)
        if fds:
            arguments += ["--plan", str(self._plan_fd), "--fds", fds_to_text(fds)]
            keep.append(self._plan_fd)
        if child.life and child.life not in fds:  # a counter alone, which it finds without arguments
            keep.append(self._fds[child.life])
            environment[LIFE] = str(self._fds[child.life])
        return arguments, keep, environment


def loaded_before(modules: Iterable[str]) -> frozenset[str]:
    """Modules of a run's processes that their parent loads: a later process needs the same, or most of it."""
    return frozenset(LOADED_TWICE[module] for module in modules if module in LOADED_TWICE)


def _ready_to_run(parent: int) -> None:
    """In the child, before its program: a hung one dies with its parent, too, and no terminal ends or suspends it."""
    die_with_parent(parent, signal.SIGKILL)
    survive_terminal()
