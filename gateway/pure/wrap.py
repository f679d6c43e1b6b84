"""Did a multi-turn encoder count round while nobody looked?  It then shows another position by its whole range."""

RANGES_TURNS = (4096, 65536, 1024)  # what multi-turn encoders count to, the usual one first
INT32 = 2**32


def wrapped(last_inc: int, now_inc: int, inc_per_turn: int, tolerance_turns: float = 0.5) -> int:
    """Increments the encoder jumped by: a multiple of one of the usual ranges; 0: it did not, or the axis was moved by hand."""
    away = now_inc - last_inc
    tolerance = tolerance_turns * inc_per_turn
    for span in (*(turns * inc_per_turn for turns in RANGES_TURNS), INT32):
        rounds = round(away / span)
        if rounds and abs(away - rounds * span) <= tolerance:
            return rounds * span
    return 0
