"""Tests assert for themselves: nothing in the folders of tests turns a crash of what is tested into a failed assertion."""

import ast
import pathlib
from collections.abc import Iterator

import pytest

HERE = pathlib.Path(__file__).resolve().parents[2]
FUZZ = HERE / "fuzz" / "player.py"  # reports the log of a finding; carries no mark


def disguises(source: str) -> Iterator[int]:
    """Lines of handlers that catch whatever comes and fail, or answer with the exception's text."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ExceptHandler) and (node.type is None or ast.unparse(node.type) in ("Exception", "BaseException")):
            last = ast.unparse(node.body[-1])
            if last.startswith(("raise AssertionError", "pytest.fail", "return repr(", "return [repr(", "assert ")):
                yield node.lineno


@pytest.mark.parametrize(
    "handler", ["except Exception as e:\n    raise AssertionError(e) from e", "except Exception as e:\n    pytest.fail(repr(e))",
                "except:\n    assert False", "except BaseException as e:\n    return repr(e)"],
)  # fmt: skip
def test_a_disguise_is_found(handler: str) -> None:
    body = handler.replace("\n", "\n    ")
    assert list(disguises(f"def f():\n    try:\n        x()\n    {body}\n")) == [4]


def test_no_crash_is_disguised_as_an_assertion() -> None:
    found = [
        f"{path.relative_to(HERE)}:{line}" for path in sorted(HERE.rglob("*.py")) if path != FUZZ for line in disguises(path.read_text())
    ]
    assert found == []
