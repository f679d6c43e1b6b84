"""Detects a multi-turn encoder that overflowed while the gateway was off.  Its position is then wrong by its full range."""

import math

RANGES_TURNS = (4096, 65536, 1024)  # what multi-turn encoders count to, the usual one first
INT32 = 2**32
HALF_TURN = 0.5
FINE = 64  # of a round of an endless axis: with few motor turns a round, half a turn would be any place


def _spans(inc_per_turn: int) -> list[int]:
    return [*(turns * inc_per_turn for turns in RANGES_TURNS), INT32]


def wrapped(last_inc: int, now_inc: int, inc_per_turn: int) -> int:
    """Increments the encoder jumped by: a multiple of one of the usual ranges; 0: it did not, or the axis was moved by hand."""
    away = now_inc - last_inc
    for span in _spans(inc_per_turn):
        rounds = round(away / span)
        if rounds and abs(away - rounds * span) <= HALF_TURN * inc_per_turn:
            return rounds * span
    return 0


def wrapped_endless(last_inc: int, now_inc: int, inc_per_turn: int, round_inc: float) -> int:
    """Return the same for an endless axis, whose increments are known modulo `round_inc`.

    The result is one range where an overflow explains the new position; 0: the axis is where it was, or it was turned by hand.  Turning
    by hand may also have led to the position of an overflow.
    """
    tolerance = min(HALF_TURN * inc_per_turn, round_inc / FINE)
    if abs(beside(now_inc - last_inc, round_inc)) <= tolerance:
        return 0
    jumps = (sign * span for span in _spans(inc_per_turn) for sign in (1, -1))
    return next((jump for jump in jumps if abs(beside(now_inc - last_inc - jump, round_inc)) <= tolerance), 0)


def beside(inc: float, round_inc: float) -> float:
    """Return the increments modulo one round, the shorter way."""
    return math.remainder(inc, round_inc)
