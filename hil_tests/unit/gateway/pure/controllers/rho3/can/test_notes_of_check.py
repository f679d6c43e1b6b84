"""What `axisgate check` says about referencing modes and the booster's zero, without calling it wrong."""

from gateway.cell_file.load import load_cell
from hil_tests.unit.gateway.pure.controllers.rho3.can.test_7_3_parameter_download import cell


def test_modes_1_and_3_get_their_segments_or_learn_that_there_are_none() -> None:
    whole = load_cell("rho3-servodyn")
    said = {notice.where: notice.text for notice in whole.notices if "referencing mode" in notice.text}
    assert "no decimals, so turns are ambiguous" in said["axis 1"] and "axis 4" not in said  # mode 2
    text = "\n".join(str(n.text) for n in cell(False, ("gear_factor = 121.0", "gear_factor = 4.1")).notices)
    assert "10 segments of 36 degrees at the resolver, 8.78049 degrees at the axis" in text


def test_a_reference_that_ends_far_from_a_resolver_zero_is_a_warning_when_limits_are_downloaded() -> None:
    """P208 = 1 degree x 121 turns = 0.336 of a motor turn: 121 degrees at the resolver."""
    offset = ("P208 = [   0.0,", "P208 = [   1.0,")
    warned = [notice for notice in cell(True, offset).warnings if "resolver zero" in notice.text]
    assert [notice.where for notice in warned] == ["axis 1"] and "ends 121 degrees" in warned[0].text
    assert not [notice for notice in cell(False, offset).warnings if "resolver zero" in notice.text]
