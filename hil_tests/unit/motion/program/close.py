"""Programs compared as the text form promises: numbers to 1e-12 of their size, orientations to 1e-9 rad."""

from dataclasses import fields, is_dataclass
from enum import Enum

from motion.geometry.frames import Pose
from motion.geometry.orientation import angle_between
from motion.program.blocks import Program


def same(a: object, b: object) -> bool:
    return _same(a, b)


def same_program(a: Program, b: Program) -> bool:
    return _same(a, b)


def _same(a: object, b: object) -> bool:
    if a is b:
        return True
    if isinstance(a, Pose) and isinstance(b, Pose):
        return _same(tuple(a.position), tuple(b.position)) and angle_between(a.rotation, b.rotation) <= 1e-9
    if type(a) is not type(b):
        return False
    if is_dataclass(a) and not isinstance(a, type):
        return all(_same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.compare)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= 1e-12 * max(1.0, abs(a))
    return a is b if isinstance(a, Enum) else a == b
