"""Definitions of the product that nothing but tests names become fewer (AX-851)."""

import pytest

from hil_tests.house.dead import Definition, allowed, dead, found, full, judged, lowered, read

USED = "class Part:\n    def used(self) -> int:\n        return 1\n\n    def spare(self) -> int:\n        return self.spare()\n"
USER = "from a import Part\n\nprint(Part().used())\n"


def names(first: str, second: str = USER, elsewhere: str = "", kept: str = "") -> list[str]:
    sources = {"a.py": read("a.py", first), "b.py": read("b.py", second)}
    return [each.name for each in dead(sources, set(elsewhere.split()), set(kept.split()))]


def test_nothing_of_the_product_is_named_by_tests_alone_beyond_what_is_allowed() -> None:
    assert judged(found(), allowed()) == []


def test_a_method_that_only_itself_names_is_dead() -> None:
    assert names(USED) == ["Part.spare"]
    assert names(USED, "import a\n") == ["Part", "Part.used", "Part.spare"], "an import alone is no use"


@pytest.mark.parametrize("how", ["elsewhere", "kept"])
def test_what_a_script_or_a_requirement_mark_names_is_kept(how: str) -> None:
    assert names(USED, **({"elsewhere": "spare"} if how == "elsewhere" else {"kept": "a:Part.spare"})) == []


def test_what_a_decorator_registers_is_alive_and_a_property_is_not() -> None:
    assert names("@command('x')\ndef it() -> None: ...\n", "") == []
    assert names("class A:\n    @property\n    def it(self) -> int:\n        return 1\n\nA()\n", "") == ["A.it"]


def test_what_is_allowed_only_falls() -> None:
    one = Definition("a.py", "Part.spare", 5, 6)
    assert full(one) == "a:Part.spare"
    assert judged([one], {"a.py": 1}) == [] and judged([one], {}) == ["a.py:5: nothing but tests names Part.spare"]
    assert lowered([one], {"a.py": 4, "gone.py": 2}) == {"a.py": 1} and lowered([one], {}) == {}
