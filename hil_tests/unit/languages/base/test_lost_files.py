"""What a program has written and is not on the disk is known once it is over: the interpreter reports it with its end."""

import pathlib

from gateway.pure.languages.base.kept import Kept


def test_a_run_reports_what_was_lost_while_it_was_under_way() -> None:
    kept = Kept()
    assert kept.written(["A"]) == []
    kept.begins(1)
    assert kept.written(["B"]) == []
    kept.begins(2)
    kept.over(1)
    assert kept.written(["C", "B"]) == [(1, ["B", "C"])]
    kept.over(2)
    kept.over(1 << 20)  # a program has started it
    assert kept.written([]) == [(2, ["C", "B"])]
    assert kept.written(["D"]) == []
