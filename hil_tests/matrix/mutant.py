"""A mutant: one function whose body is replaced, in place: by `raise`, by `return <default>`, or changed in one small place.

The code object is exchanged, not the name: everybody who imported the function earlier meets the mutant too.  Child processes
learn it from the environment (child/sitecustomize.py) and meet the same mutant.
"""

import contextlib
import functools
import importlib
import inspect
import itertools
import os
import pathlib
import types
import typing
from collections.abc import Iterator

from hil_tests.matrix import small
from hil_tests.matrix.catalogue import resolve

VARIABLE = "AXISGATE_MUTANT"  # "raise module:function", "return module:function", or a small one's name before it
VARIANTS = ("raise", "return")
CHILD = pathlib.Path(__file__).resolve().parent / "child"
DEFAULTS = {  # by the outermost type of the return annotation
    "bool": "False", "int": "0", "float": "0.0", "complex": "0j", "str": "''", "bytes": "b''", "bytearray": "bytearray()",
    "list": "[]", "Sequence": "[]", "Iterable": "[]", "Collection": "[]", "Iterator": "iter(())", "Generator": "iter(())",
    "tuple": "()", "dict": "{}", "Mapping": "{}", "MutableMapping": "{}", "set": "set()", "Set": "set()", "frozenset": "frozenset()",
    "Ns": "0",
}  # fmt: skip


class MutantError(Exception):
    """What the `raise` variant raises; only this, so that a test can never mistake it for an assertion."""


@contextlib.contextmanager
def mutated(name: str, variant: str, children: bool = True) -> Iterator[None]:
    """While inside, "module:function" is broken here and in every Python child started meanwhile."""
    function = resolve(name)
    kept, environment = function.__code__, dict(os.environ)
    function.__code__ = changed(name, variant)
    if children:
        os.environ[VARIABLE] = f"{variant} {name}"
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(CHILD), environment.get("PYTHONPATH", "")]))
    forget_results(name)
    try:
        yield
    finally:
        function.__code__ = kept
        forget_results(name)
        for variable in (VARIABLE, "PYTHONPATH"):
            os.environ.pop(variable, None)
            if variable in environment:
                os.environ[variable] = environment[variable]


def changed(name: str, variant: str) -> types.CodeType:
    """The code of a variant of "module:function", whose own code is still in place."""
    return broken(resolve(name), variant) if variant in VARIANTS else small.code_of(name, variant)


def broken(function: types.FunctionType, variant: str) -> types.CodeType:
    """A code object that fits `function` (same free variables, same kind) with another body."""
    body = "raise MUTANT" if variant == "raise" else f"return {default_of(function)}"
    if inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function):
        body = "raise MUTANT\n        yield" if variant == "raise" else "return\n        yield"
    kind = "async def" if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function) else "def"
    free = ", ".join(function.__code__.co_freevars)
    source = f"def outer({free}):\n    {kind} mutant(*args, **kwargs):\n        {body}\n        ({free or 'None'})\n    return mutant\n"
    space: dict[str, object] = {}
    exec(compile(source.replace("MUTANT", "'MUTANT'"), "<mutant>", "exec"), space)
    outer = space["outer"]
    assert isinstance(outer, types.FunctionType)
    made: types.FunctionType = outer(*itertools.repeat(None, len(function.__code__.co_freevars)))
    constants = tuple(MutantError if constant == "MUTANT" else constant for constant in made.__code__.co_consts)
    return made.__code__.replace(co_consts=constants, co_name=function.__code__.co_name, co_qualname=function.__code__.co_qualname)


def default_of(function: types.FunctionType) -> str:
    """Source of the value a mutant returns: empty or zero of the annotated type, None where there is none."""
    annotation = function.__annotations__.get("return")
    with contextlib.suppress(Exception):
        annotation = typing.get_type_hints(function).get("return", annotation)
    origin = typing.get_origin(annotation) or annotation
    if origin in (typing.Union, types.UnionType):
        parts = typing.get_args(annotation)
        origin = None if type(None) in parts else typing.get_origin(parts[0]) or parts[0]
    name = origin if isinstance(origin, str) else getattr(origin, "__name__", "")
    return DEFAULTS.get(name.partition("[")[0], "None")


def forget_results(name: str) -> None:
    """Empties the memory of a cached function."""
    module, _, qualname = name.partition(":")
    with contextlib.suppress(AttributeError):
        found = functools.reduce(getattr, qualname.split("."), importlib.import_module(module))
        found.cache_clear()
