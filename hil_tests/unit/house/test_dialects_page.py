"""docs/guide/dialects.md says what the profiles are."""

import importlib.util
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[3]


def test_the_page_of_dialects_is_the_one_the_tables_give() -> None:
    spec = importlib.util.spec_from_file_location("dialects_page", ROOT / "docs" / "dialects.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (ROOT / "docs" / "guide" / "dialects.md").read_text() == module.page(), "run: python docs/dialects.py"
