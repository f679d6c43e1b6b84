"""Orientation along a curve as R(s) = R0 exp(rho(s)): derivatives of the exponential, so that rates and their changes are exact.

rho: rotation vector in rad, in the frame R0.  The rate of turning seen in that frame is A(rho) rho' with the left Jacobian A of
the rotation group (Rodrigues).
"""

import math

from motion.geometry.frames import Vector
from motion.paths.base import add, cross, dot, scale, sub

SMALL = 1e-4  # rad: below it the coefficients come from their series


def _factors(square: float) -> tuple[float, float, float, float]:
    """(1 - cos x) / x^2, (x - sin x) / x^3 and their derivatives by x^2 / 2, from x^2."""
    if square < SMALL:
        a = 0.5 - square / 24 + square * square / 720
        b = 1 / 6 - square / 120 + square * square / 5040
        return a, b, -1 / 12 + square / 180, -1 / 60 + square / 1260
    x = math.sqrt(square)
    sine, cosine = math.sin(x), math.cos(x)
    a, b = (1 - cosine) / square, (x - sine) / (square * x)
    return a, b, (sine / x - 2 * a) / square, (a - 3 * b) / square


def rate(rho: Vector, rho1: Vector) -> Vector:
    """Rate of turning in the frame of R0, rad per unit of s."""
    a, b, _, _ = _factors(dot(rho, rho))
    first = cross(rho, rho1)
    return add(rho1, add(scale(first, a), scale(cross(rho, first), b)))


def rate_change(rho: Vector, rho1: Vector, rho2: Vector) -> Vector:
    """d(rate)/ds."""
    a, b, da, db = _factors(dot(rho, rho))
    k = dot(rho, rho1)
    first, second = cross(rho, rho1), cross(rho, rho2)
    double = cross(rho, first)
    change = add(scale(first, da * k), scale(double, db * k))
    inner = add(cross(rho1, first), cross(rho, second))
    return add(rho2, add(change, add(scale(second, a), scale(inner, b))))


def vector_rate(rho: Vector, omega: Vector) -> Vector:
    """rho' that turns at omega: the inverse of `rate`; |rho| < 2 pi."""
    square = dot(rho, rho)
    if square < SMALL:
        k = 1 / 12 + square / 720
    else:
        x = math.sqrt(square)
        k = 1 / square - math.cos(0.5 * x) / (2 * x * math.sin(0.5 * x))
    first = cross(rho, omega)
    return add(sub(omega, scale(first, 0.5)), scale(cross(rho, first), k))


def vector_change(rho: Vector, rho1: Vector, omega1: Vector) -> Vector:
    """rho'' for which the rate changes by omega1."""
    return vector_rate(rho, sub(omega1, rate_change(rho, rho1, (0.0, 0.0, 0.0))))
