"""A wheel gets the cycle's parts in C (AX-320) where there is a compiler, and says so where there is none."""

import pathlib
import subprocess
import sys

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class NativeParts(BuildHookInterface):
    """An editable install is served by `make native`."""

    def initialize(self, version: str, build_data: dict[str, object]) -> None:
        if self.target_name != "wheel" or version == "editable":
            return
        done = subprocess.run(
            [sys.executable, "-m", "gateway.cycle.native.build"], cwd=self.root, capture_output=True, text=True, check=False
        )
        if done.returncode:
            self.app.display_warning(f"without all parts in C, their Python twins run: {done.stderr.strip()}")
        made = sorted(pathlib.Path(self.root).glob(f"gateway/cycle/native/*{suffix()}"))
        if made:
            build_data["force_include"] = {str(file): f"gateway/cycle/native/{file.name}" for file in made}
            build_data["pure_python"], build_data["infer_tag"] = False, True


def suffix() -> str:
    """Of libraries this interpreter loads."""
    import sysconfig

    return str(sysconfig.get_config_var("EXT_SUFFIX"))
