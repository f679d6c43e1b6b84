"""Restore a backup: its files are checked before anything is changed; existing files are kept under another name."""

import argparse
import json
import pathlib

from drivers.ports.base import PortError, runtime_dir
from gateway.recording import backup
from gateway.runtime.supervisor_client import ask
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate restore cell.zip --to /etc/axisgate --dry-run    check it and report what would be done; changes nothing
  axisgate restore cell.zip --to /etc/axisgate              into a folder that has none of its files, or the same ones
  axisgate restore cell.zip --to /etc/axisgate --replace    other files of that name are kept as NAME.before-TIME
exit code: 0 restored (or --dry-run: could be), 1 other files are in the way, 2 not a backup or unfit, 3 the gateway is running"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate restore", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", metavar="FILE", type=pathlib.Path, help="what `axisgate backup` wrote")
    parser.add_argument("--to", metavar="FOLDER", required=True, type=pathlib.Path, help="folder of the cell file")
    parser.add_argument("--dry-run", action="store_true", help="check and report what would be done")
    parser.add_argument("--replace", action="store_true", help="replace other files of the same name")
    parser.add_argument("--json", action="store_true", help="what is done with each file, as JSON on standard output")
    options = parser.parse_args(argv)
    try:
        manifest = backup.read(options.file)
        steps = backup.steps(manifest, options.to)
        _print_steps(manifest, steps, as_json=options.json)
        running = runs_of(options.to / manifest.cell)
        if running:
            complain("restore", f"{running} is running this cell; stop it first")
            return ENVIRONMENT
        others = [step.part.name for step in steps if step.what == "replaced"]
        if others and not options.replace:
            complain("restore", f"{', '.join(others)}: other files are in the way; --replace keeps them as copies")
            return FINDING
        if options.dry_run:
            backup.try_out(options.file, manifest)
            return DONE
        kept = backup.restore(options.file, manifest, options.to)
    except backup.BackupError as error:
        complain("restore", error)
        return USAGE
    except (OSError, PortError) as error:
        complain("restore", error)
        return ENVIRONMENT if options.file.exists() else USAGE
    if not options.json:
        for path in kept:
            print(f"kept: {path}")
        for name in manifest.withheld:
            if not (options.to / name).exists():
                print(f"not in the backup: {name} (a secret); put it there, readable only by the user of the gateway (0600)")
        for name in backup.others(manifest, options.to):
            print(f"stays: {name} is not in the backup; remove it if the programs are to be those of the backup alone")
        print(f"restored; next: axisgate check {options.to / manifest.cell}")
    return DONE


def runs_of(cell: pathlib.Path) -> str:
    """Name of a run of this cell file on this computer; "": none answers."""
    wanted = str(cell.resolve())
    for path in sorted(runtime_dir().glob("*.sock")):
        try:
            with ask(path.stem, "status", 1.0) as connection:
                status = json.loads(connection.makefile().readline() or "{}")
        except (PortError, OSError, ValueError):
            continue
        if status.get("file") == wanted:
            return path.stem
    return ""


def _print_steps(manifest: backup.Manifest, steps: list[backup.Step], *, as_json: bool) -> None:
    if as_json:
        rows = [{"name": step.part.name, "role": step.part.role, "what": step.what} for step in steps]
        print(json.dumps({"cell": manifest.cell, "version": manifest.version, "wall": manifest.wall, "files": rows}, indent=1))
        return
    print(f"{manifest.title}: {manifest.cell}, saved {manifest.wall} by axisgate {manifest.version}")
    for step in steps:
        print(f"{step.what:9} {step.part.role:18} {step.part.name}")
