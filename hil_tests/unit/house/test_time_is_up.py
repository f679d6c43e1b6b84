"""A CI run that is out of time begins no further test (AX-1512)."""

import pathlib

import pytest

from hil_tests import conftest


def test_no_test_begins_once_the_time_is_up(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flag = tmp_path / "time-is-up"
    monkeypatch.setattr(conftest, "TIME_IS_UP", flag)
    conftest.pytest_runtest_setup()
    flag.touch()
    with pytest.raises(pytest.skip.Exception, match="the time of this run was up"):
        conftest.pytest_runtest_setup()
    flag.unlink()  # the hook looks at it again before the next test
