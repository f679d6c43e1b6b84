"""The rows of a track that are in view: whatever comes and goes, each row that is held is the one that came last under its number."""

import random

import numpy as np
import pytest

from motion.timing.window import ROOM, Window


@pytest.mark.parametrize("seed", range(3))
def test_rows_come_and_go_and_none_is_another_one(seed: int) -> None:
    dice, window, value = random.Random(seed), Window(2, 3), 0
    held: dict[int, float] = {}
    for more in range(59, -1, -1):
        match dice.randint(0, 5) if more else 5:  # rows come last
            case 0:
                window.cut(dice.randint(window.low, window.end))
            case 1 if dice.random() < 0.1:
                window.begin(dice.randint(0, 10 * ROOM))
                held.clear()
            case _:
                count = dice.choice((1, 64, 300, ROOM, 3 * ROOM))
                low = dice.randint(window.low, window.end)
                window.room(low, window.end + count)
                rows = np.arange(value, value + count, dtype=np.float32) % 8192
                value += count
                held.update(zip(range(window.end, window.end + count), rows.tolist(), strict=True))
                window.add(np.broadcast_to(rows, (2, 3, count)), bytes(int(row) % 3 == 0 for row in rows))
                assert window.low <= low
        count = window.end - window.low
        seen = window.rows[:, :, :count]
        assert np.array_equal(seen, np.broadcast_to([held[row] for row in range(window.low, window.end)], (2, 3, count)))
    assert window.rows.shape[2] > ROOM  # more than it had room for was wanted at once
    for row in (window.low, window.end - 1, window.low - 5, window.end + 5):
        inside = min(max(row, window.low), window.end - 1)
        assert window.rests(row) == (held[inside] % 3 == 0)
