"""The worked example of docs/guide/val3-sio.md, run as it stands there."""

import re
import subprocess
import sys

from hil_tests.purity import ROOT


def test_the_example_of_the_guide_prints_what_it_says() -> None:
    guide = (ROOT / "docs" / "guide" / "val3-sio.md").read_text()
    (program,) = re.findall(r"```python\n(.*?)```", guide, re.DOTALL)
    (wanted,) = re.findall(r"```text\n(.*?)```", guide, re.DOTALL)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30, check=False, cwd=ROOT)
    assert (done.stdout, done.stderr) == (wanted, "")
