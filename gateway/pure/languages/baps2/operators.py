"""Types and translates the operators of expressions, once the operands are translated.  A faulty one is reported and has the type NONE."""

import operator
from typing import Protocol

from gateway.pure.languages.baps2 import values
from gateway.pure.languages.baps2.tree import Binary, Unary
from gateway.pure.languages.baps2.typed import NOTHING, Typed
from gateway.pure.languages.baps2.types import BINARY, INTEGER, LETTERS, NONE, NUMBERS, POINTS, REAL, fits
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.base.source import Position

COMPARISONS = {"=": "==", "<>": "!=", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
CHECKED = "(t if -2147483648 <= (t := {}) <= 2147483647 else overflow())"


class Report(Protocol):
    """Reports a fault; returns the type NONE."""

    def __call__(self, id: str, at: Position, text: str) -> Typed:
        """One fault."""


class Operators:
    """Signs, arithmetic, comparisons and points."""

    def __init__(self, fault: Report) -> None:
        self._fault = fault

    def sign(self, tree: Unary, value: Typed) -> Typed:
        """+, - or % of a value."""
        if value.type is NONE:
            return NOTHING
        if value.type.base in POINTS and tree.sign != "%" and not value.type.is_array:
            return value if tree.sign == "+" else Typed(value.type, f"scaled({value.code}, -1)")
        if value.type not in (INTEGER, REAL):
            return self._fault("type", tree.at, f"{value.type} has no sign")
        constant = value.constant if isinstance(value.constant, int | float) else None
        if tree.sign == "%":
            return Typed(REAL, f"({value.code} / 100)", None if constant is None else constant / 100)
        if tree.sign == "+":
            return value
        if constant is not None:
            return Typed(value.type, f"({-constant!r})", -constant)
        return Typed(value.type, CHECKED.format(f"-{value.code}") if value.type == INTEGER else f"(-{value.code})")

    def between(self, tree: Binary, left: Typed, right: Typed) -> Typed:
        """A comparison, arithmetic or an operation on points."""
        if left.type is NONE or right.type is NONE:
            return NOTHING
        if tree.sign in COMPARISONS:
            return self._comparison(tree, left, right)
        if left.type in (INTEGER, REAL) and right.type in (INTEGER, REAL):
            return self._arithmetic(tree, left, right)
        if left.type.base in POINTS or right.type.base in POINTS:
            return self._points(tree, left, right)
        return self._fault("type", tree.at, f"{left.type} {tree.sign} {right.type} is not possible")

    def _points(self, tree: Binary, left: Typed, right: Typed) -> Typed:
        if not (left.type.is_array or right.type.is_array):
            if tree.sign in ("+", "-") and fits(left.type, right.type):
                kind = left.type if left.type.kinematic else right.type
                return Typed(kind, f"joined({tree.sign!r}, {left.code}, {right.code})")
            if tree.sign == "*" and right.type.base in NUMBERS:
                return Typed(left.type, f"scaled({left.code}, {right.code})")
            if tree.sign == "*" and left.type.base in NUMBERS:
                return Typed(right.type, f"scaled({right.code}, {left.code})")
            if tree.sign == "/" and right.type.base in NUMBERS:
                return Typed(left.type, f"scaled({left.code}, divide(1, {right.code}))")
        return self._fault("type", tree.at, f"{left.type} {tree.sign} {right.type} is not possible")

    def _comparison(self, tree: Binary, left: Typed, right: Typed) -> Typed:
        code = f"({left.code} {COMPARISONS[tree.sign]} {right.code})"
        arrays = left.type.is_array or right.type.is_array
        if not arrays and left.type.base in NUMBERS and right.type.base in NUMBERS:
            return Typed(BINARY, code, truth=True)
        if not arrays and left.type.base in LETTERS and right.type.base in LETTERS:
            return Typed(BINARY, code, truth=True)
        equal = tree.sign in ("=", "<>")
        for one, other in ((left, right), (right, left)):
            if equal and not arrays and one.type == BINARY and fits(BINARY, other.type, other.constant):
                return Typed(BINARY, code, truth=True)
        if equal and not arrays and left.type.base in POINTS and fits(left.type, right.type):
            return Typed(BINARY, f"(point({left.code}) {COMPARISONS[tree.sign]} point({right.code}))", truth=True)
        return self._fault("type", tree.at, f"{left.type} {tree.sign} {right.type} is not possible")

    def _arithmetic(self, tree: Binary, left: Typed, right: Typed) -> Typed:
        sign, whole = tree.sign, left.type == right.type == INTEGER
        if sign == "MOD" and not whole:
            return self._fault("type", tree.at, "MOD takes INTEGER values")
        if left.constant is not None and isinstance(left.constant, int | float) and isinstance(right.constant, int | float):
            return self._folded(tree, left.constant, right.constant, whole)
        if sign == "MOD":
            if isinstance(right.constant, int) and right.constant:
                return Typed(INTEGER, f"({left.code} % {abs(right.constant)})")
            return Typed(INTEGER, f"modulo({left.code}, {right.code})")
        if sign == "/":
            return Typed(INTEGER, f"quotient({left.code}, {right.code})") if whole else Typed(REAL, f"divide({left.code}, {right.code})")
        code = f"{left.code} {sign} {right.code}"
        return Typed(INTEGER, CHECKED.format(code)) if whole else Typed(REAL, f"({code})")

    def _folded(self, tree: Binary, left: float, right: float, whole: bool) -> Typed:
        try:
            if tree.sign == "MOD":
                value: float = values.modulo(int(left), int(right))
            elif tree.sign == "/":
                value = values.quotient(int(left), int(right)) if whole else values.divide(left, right)
            else:
                value = {"+": operator.add, "-": operator.sub, "*": operator.mul}[tree.sign](left, right)
            if whole and not values.LOWEST <= value <= values.HIGHEST:
                values.overflow()
            value = int(value) if whole else values.real(value)
        except RuntimeFault as error:
            return self._fault("constant", tree.at, error.text)
        return Typed(INTEGER if whole else REAL, f"({value!r})", value)
