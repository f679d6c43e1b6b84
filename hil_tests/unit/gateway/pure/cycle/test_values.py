"""Named values: quality, stamp, signals that count."""

import pytest

from gateway.pure.image.named_values import Sample, Values
from gateway.pure.image.records.cell import Quality
from protocols.base.machine import ms


def test_a_value_is_bad_until_written_and_stale_when_its_source_is_away() -> None:
    values = Values(["order.number", "order.done"], ["order.new"])
    assert values.names() == ["order.done", "order.new", "order.number"] and "order.number" in values and "x.y" not in values
    assert values.sample("order.number") == Sample(None, Quality.BAD)
    with pytest.raises(KeyError):
        values.get("order.number")
    values.put("order.number", 7, ms(5), "V24_1/ORDER")
    values.put("order.done", True, ms(6), "var")
    assert values.sample("order.number") == Sample(7, Quality.GOOD, ms(5), "V24_1/ORDER")
    values.source_gone("V24_1")
    assert values.sample("order.number") == Sample(7, Quality.STALE, ms(5), "V24_1/ORDER") and values.get("order.number") == 7
    assert values.sample("order.done").quality is Quality.GOOD
    values.put("order.number", 8, ms(9), "V24_1/ORDER")
    assert values.sample("order.number").quality is Quality.GOOD


def test_a_signal_counts_every_giving_and_stays_good() -> None:
    values = Values([], ["order.new"])
    assert values.get("order.new") == 0
    values.give("order.new", ms(1), "V24_1/ORDER")
    values.put("order.new", 99, ms(2), "var")  # whatever is written: it is given once more
    assert values.sample("order.new") == Sample(2, Quality.GOOD, ms(2), "var")
    values.source_gone("var")
    assert values.sample("order.new").quality is Quality.GOOD


@pytest.mark.parametrize("call", ["put", "give", "get", "sample"])
def test_a_name_the_cell_does_not_use_is_refused(call: str) -> None:
    values = Values(["order.number"])
    arguments = {"put": ("order.nr", 1, 0, "var"), "give": ("order.nr", 0, "var")}.get(call, ("order.nr",))
    with pytest.raises(KeyError):
        getattr(values, call)(*arguments)
    assert values.names() == ["order.number"]
