"""Detects a multi-turn encoder that overflowed while the gateway was off.  It then shows another position by its whole range."""

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
    """The same of an endless axis, whose increments are known but for whole rounds of `round_inc`: one range, where that shows it at such
    another place; 0: it is where it was, or it was turned by hand.  By hand it may have been turned there, too."""
    tolerance = min(HALF_TURN * inc_per_turn, round_inc / FINE)
    if abs(beside(now_inc - last_inc, round_inc)) <= tolerance:
        return 0
    jumps = (sign * span for span in _spans(inc_per_turn) for sign in (1, -1))
    return next((jump for jump in jumps if abs(beside(now_inc - last_inc - jump, round_inc)) <= tolerance), 0)


def beside(inc: float, round_inc: float) -> float:
    """Increments without whole rounds, the shorter way."""
    return math.remainder(inc, round_inc)
