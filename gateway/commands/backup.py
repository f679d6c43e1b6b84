"""Save a cell in one file: cell file, the tables and DAT files it names, programs, retained data. A running gateway continues."""

import argparse
import json
import pathlib

from gateway.recording import backup
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate backup cell.toml --to cell-2026-11-21.zip           everything that makes this cell
  axisgate backup cell.toml --to /media/usb/cell.zip --json    its contents, for scripts
  axisgate backup demo --to demo.zip                           of a shipped cell, as an example
  axisgate restore cell-2026-11-21.zip --to /etc/axisgate --dry-run    what restoring it would do
exit code: 0 saved, 2 the cell is invalid, 3 it cannot be written"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate backup", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--to", metavar="FILE", required=True, type=pathlib.Path, help="the ZIP file to write")
    parser.add_argument(
        "--secrets",
        action="store_true",
        help="also private keys, password files and the users of the page; then only you can read FILE (0600)",
    )
    parser.add_argument("--json", action="store_true", help="its contents as JSON on standard output")
    options = parser.parse_args(argv)
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    try:
        manifest = backup.make(cell, options.to, secrets=options.secrets)
    except (OSError, backup.BackupError) as error:
        complain("backup", error)
        return ENVIRONMENT
    if options.json:
        rows = [{"name": part.name, "role": part.role, "size": part.size, "sha256": part.sha256} for part in manifest.parts]
        missing = {"left_out": manifest.left_out, "withheld": manifest.withheld}
        print(json.dumps({"file": str(options.to), "version": manifest.version, "parts": rows, **missing}, indent=1))
        return DONE
    for part in manifest.parts:
        print(f"{part.role:18} {part.size:>9}  {part.name}")
    for name in manifest.left_out:
        print(f"left out: {name} is outside the folder of the cell; save it yourself")
    for name in manifest.withheld:
        print(f"withheld: {name} (a secret); --secrets includes it, or save it yourself")
    print(f"{options.to}: {len(manifest.parts)} files; try it: axisgate restore {options.to} --to FOLDER --dry-run")
    return DONE
