"""Read by every Python process started while a mutant is on: breaks the same function there, right after its module loads."""

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import runpy
import sys
import types
from collections.abc import Sequence


class Breaker(importlib.abc.MetaPathFinder):
    """Lets the ordinary finders find the module, then breaks the function when it has been executed."""

    def __init__(self, variant: str, name: str) -> None:
        self._variant, self._name, self._module = variant, name, name.partition(":")[0]

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self._module:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        if spec is None or spec.loader is None:
            return None
        execute = spec.loader.exec_module

        def exec_module(module: types.ModuleType) -> None:
            execute(module)
            from hil_tests.matrix.catalogue import resolve
            from hil_tests.matrix.mutant import changed

            resolve(self._name).__code__ = changed(self._name, self._variant)

        spec.loader.exec_module = exec_module  # type: ignore[method-assign]  # one loader object, ours alone, in a process made to break
        return spec


run_as_main = runpy._run_module_as_main  # type: ignore[attr-defined]  # what `python -m` calls; there is no public one


def run_broken(module: str, alter_argv: bool = True) -> object:
    """`python -m MODULE` runs a second copy of the module, which no finder meets: of the broken one its main() is called instead."""
    if module != name.partition(":")[0]:
        return run_as_main(module, alter_argv)
    sys.exit(importlib.import_module(module).main())


variant, _, name = os.environ.get("AXISGATE_MUTANT", "").partition(" ")
if name:
    sys.meta_path.insert(0, Breaker(variant, name))
    setattr(runpy, "_run_module_as_main", run_broken)  # noqa: B010 its stub does not know the name
