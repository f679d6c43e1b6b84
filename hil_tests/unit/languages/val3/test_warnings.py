"""What an application may do and had better not: warnings of `axisgate val3 check`."""

import pytest

from hil_tests.unit.languages.val3.apps import App, check, datum, value


def warned(mdesc: str) -> list[str]:
    found = check(App(data=mdesc))
    assert found.errors == 0
    return [each.text for each in found]


@pytest.mark.requirement("VAL-MOV-12", by="gateway.pure.languages.val3.loader:Loader._speeds")
def test_above_the_nominal_speed_accelerations_that_do_not_go_with_it_are_named() -> None:
    """L5654: 120 % goes with 144 %."""
    assert warned(datum("mFast", "mdesc", "1", value(vel=120))) == [
        "'mFast' : vel 120 % does not match accel and decel of 144 %, not 100 % and 100 %"
    ]
    assert warned(datum("mFast", "mdesc", "1", value(vel=120, accel=144, decel=300))) == [
        "'mFast' : vel 120 % does not match accel and decel of 144 %, not 144 % and 300 %"
    ]


@pytest.mark.parametrize("given", [value(vel=120, accel=144, decel=140), value(vel=30), value(accel=50), value(), value(vel="fast")])
def test_a_sound_descriptor_is_not_named(given: str) -> None:
    found = check(App(data=datum("m", "mdesc", "1", given)))
    assert not [each for each in found if each.id == "val3-speed"]


def test_fields_of_user_types_are_looked_at_too() -> None:
    held = datum("m", "mdesc", "2", value("0") + value("1", vel=200))
    part = App("part", held)
    types = '<Type name="Part" path="Disk://part/part.pjx" />'
    inner = '<Value key="0"><Field name="m" xsi:type="array" type="mdesc" size="1"><Value key="0" vel="150" /></Field></Value>'
    found = check(App(data=datum("job", "Part", "1", inner), types=types), part)
    assert [each.text for each in found] == ["'m' : vel 150 % does not match accel and decel of 225 %, not 100 % and 100 %"]
