"""VAL 3: mdesc (10.5), the tuning rule (10.3.2), the ambiguous literal (10.6)."""

import pytest

from motion.program.blocks import Rounding, changed
from motion.val3.errors import AmbiguousExpression, RuntimeFault
from motion.val3.mdesc import BlendKind, Mdesc, matching
from motion.val3.types import Form, Operand, movej_form


def code_of(mdesc: Mdesc) -> int:
    try:
        mdesc.check()
    except RuntimeFault as fault:
        return fault.code
    return 0


@pytest.mark.requirement("VAL-MOV-03", by="motion.val3.mdesc:Mdesc.check")
def test_the_default_and_the_error_of_each_field() -> None:
    default = Mdesc()
    assert (default.accel, default.vel, default.decel, default.tvel, default.rvel) == (100, 100, 100, 9999, 9999)
    assert (default.blend, default.leave, default.reach) == (BlendKind.JOINT, 50, 50)
    assert code_of(default) == 0
    codes = {"vel": 100, "accel": 101, "decel": 102, "tvel": 103, "rvel": 104, "reach": 105, "leave": 106}
    for name, code in codes.items():
        for value in (-1.0, float("nan")):
            assert code_of(changed(default, {name: value})) == code, name
    assert code_of(Mdesc(leave=0.0, reach=0.0)) == 0
    assert code_of(Mdesc(vel=0.0)) == code_of(Mdesc(vel=501.0)) == 100 and code_of(Mdesc(accel=10000.0)) == 101
    assert code_of(Mdesc(accel=9999.0, decel=9999.0)) == 0, "as applications of s7 set them"


@pytest.mark.requirement("VAL-MOV-12", by="motion.val3.mdesc:matching")
def test_vel_120_goes_with_144() -> None:
    found = matching(120.0)
    assert [found.vel, found.accel, found.decel] == pytest.approx([120.0, 144.0, 144.0])
    pace = found.pace()
    assert (pace.speed, pace.accel, pace.decel) == pytest.approx((1.2, 1.44, 1.44))
    with pytest.raises(RuntimeFault):
        matching(-1.0)


@pytest.mark.requirement("VAL-MOV-04", by="motion.val3.mdesc:Mdesc.blending")
def test_lengths_are_in_the_unit_of_the_application() -> None:
    mdesc = Mdesc(tvel=250.0, rvel=90.0, leave=10.0, reach=20.0, blend=BlendKind.CARTESIAN)
    assert mdesc.pace().path_speed == pytest.approx(0.25)
    assert mdesc.pace().turn_speed == pytest.approx(1.5707963)
    assert (mdesc.blending(0.0254).leave, mdesc.blending(0.0254).reach) == pytest.approx((0.254, 0.508))
    assert mdesc.blending().rounding is Rounding.CARTESIAN and Mdesc().blending().rounding is Rounding.JOINT
    assert Mdesc(blend=BlendKind.OFF).blending().leave == 0.0


@pytest.mark.requirement("VAL-MOV-02", by="motion.val3.types:movej_form")
def test_a_structured_literal_in_movej_is_ambiguous_and_a_variable_is_not() -> None:
    with pytest.raises(AmbiguousExpression) as caught:
        movej_form(Operand.LITERAL, "{0,0,0,0,0,0}")
    assert str(caught.value) == '"{0,0,0,0,0,0}": Ambiguous expression'
    assert movej_form(Operand.JOINT, "myJoint") is Form.MOVEJ_JOINT
    assert movej_form(Operand.POINT, "pPlace") is Form.MOVEJ_POINT
    with pytest.raises(RuntimeFault, match="joint or a point"):
        movej_form(Operand.OTHER, "nCount")
