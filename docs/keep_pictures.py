"""`make pictures`: build/pictures, written by the page's tests, into docs/pictures in few colours, so that they stay small in the tree."""

import pathlib
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[1]
COLOURS = 128


def main() -> int:
    """Exit 1: the tests have not left any."""
    found = sorted((ROOT / "build" / "pictures").glob("*.png"))
    if not found:
        print("pictures: none in build/pictures; run python -m pytest hil_tests/rig/web/test_page.py first", file=sys.stderr)
        return 1
    for path in found:
        picture = Image.open(path).convert("RGB").quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        picture.save(ROOT / "docs" / "pictures" / path.name, optimize=True)
    print(f"pictures: {len(found)} kept, {sum((ROOT / 'docs' / 'pictures' / path.name).stat().st_size for path in found) // 1000} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
