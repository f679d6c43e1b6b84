"""Names for files that are replaced and kept."""

import pathlib

from gateway.runtime.clock import wall


def kept_aside(path: pathlib.Path) -> pathlib.Path:
    """A free name for what is in the place of a file that is replaced: NAME.before-TIME-N."""
    mark = wall()[:19].replace(":", "")
    names = (path.with_name(f"{path.name}.before-{mark}-{number}") for number in range(1, 10_000))
    return next(each for each in names if not each.exists())
