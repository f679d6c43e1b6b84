"""`axisgate val3 import CARD`: a cell of the applications and the configuration on a flash card (AX-990)."""

import argparse
import json
import os
import pathlib
import shutil
import sys

from gateway.files.find import find_config, read_text
from gateway.files.val3_card import read_card, unpack_card
from gateway.files.val3_disk import DiskUnreadable
from gateway.pure.controllers.val3.sio.channel import Channel, Kind, channel_named
from gateway.pure.languages.val3.card import Card, card_of
from gateway.pure.languages.val3.disk import Disk, PathFault, application_of
from gateway.pure.languages.val3.links import links_of_files
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.model import Application
from gateway.runtime.exit_codes import Exit
from gateway.tools.new_cell.val3_cell import Parts, cell_of, drives_of
from gateway.tools.usage_language import val3_card_text, val3_text

CELLS = {"rx": "cs8", "rs": "scara"}  # family of arms -> shipped cell whose drives and plant are used


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `axisgate val3 import`."""
    parser.add_argument("card", metavar="CARD", type=pathlib.Path, help="copy of the flash card: the folder with usr in it, or its .zip")
    parser.add_argument("--application", metavar="NAME", help="application to run, if the card has several and none has autostart")
    parser.add_argument("--out", metavar="FILE", type=pathlib.Path, help="cell file to write, never overwritten (default NAME.toml)")
    parser.add_argument("--json", action="store_true", help="file, application and open points as JSON")


def run(options: argparse.Namespace) -> int:
    """DiskUnreadable, OSError."""
    folder = _folder(options.card, options.out)
    try:
        return _imported(options, folder)
    except (DiskUnreadable, OSError):
        if folder != options.card:  # made of the ZIP file a moment ago
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _imported(options: argparse.Namespace, folder: pathlib.Path) -> int:
    files = read_card(folder)
    card = card_of(files.configs)
    apps = applications(files.disk)
    chosen = choose(apps, files.disk, options.application or card.start)
    out = options.out or pathlib.Path(f"{chosen.name}.toml")
    if out.exists():
        raise DiskUnreadable(f"{out} exists already and is not changed; name another file with --out")
    links, sockets = links_of_files([chosen, *(each for each in apps if each is not chosen)])
    family = "rs" if card.arm.lower().startswith(("rs", "ts", "tp")) or _family(chosen) == "rs" else "rx"
    drives = drives_of(read_text(find_config(CELLS[family], "cells")))
    disk = os.path.relpath(files.usrapp.resolve(), out.resolve().parent)
    place = f"{chosen.path}/{chosen.name}.pjx" if chosen.path else f"{chosen.name}.pjx"
    own = chosen.path if chosen.path.rpartition("/")[2].lower() == chosen.name.lower() else place
    text, doubts = cell_of(Parts(card, own, disk, chosen.version, tuple(links), drives, str(options.card), _alters(apps)))
    doubts += _unknown(card, sockets)
    with out.open("x", encoding="utf-8") as file:
        file.write(text)
    if options.json:
        print(json.dumps({"file": str(out), "application": chosen.name, "doubts": doubts}, ensure_ascii=False))
    else:
        print(val3_text(f"{out} written, application {chosen.name}.  next: axisgate check {out}      then: axisgate run {out} --sim"))
        for doubt in doubts:
            print(f"  {val3_card_text(doubt)}", file=sys.stderr)
    return Exit.OK


def _folder(card: pathlib.Path, out: pathlib.Path | None) -> pathlib.Path:
    """The card; for a ZIP file its content, in a folder next to the cell file."""
    if not (card.is_file() and card.suffix.lower() == ".zip"):
        return card
    if out is not None and out.exists():
        raise DiskUnreadable(f"{out} exists already and is not changed; name another file with --out")
    folder = out.with_suffix("") if out is not None else pathlib.Path(card.stem)
    unpack_card(card, folder)
    return folder


def applications(disk: Disk) -> list[Application]:
    """All that can be read; the faults of the others are `check`'s."""
    loader, found = Loader(disk), []
    for path in sorted(disk.files):
        if path.lower().endswith(".pjx"):
            folder, _, name = path.rpartition("/")
            app, _ = loader.read(folder, name[:-4])
            if app is not None:
                found.append(app)
    return found


def choose(apps: list[Application], disk: Disk, wanted: str) -> Application:
    """The named one, else the only one with start() and stop() that no other one uses.  DiskUnreadable."""
    if wanted:
        name = wanted.replace("\\", "/").rstrip("/").rpartition("/")[2].removesuffix(".pjx").lower()
        named = next((app for app in apps if app.name.lower() == name), None)
        if named is None:
            raise DiskUnreadable(f"application {wanted}: the card has {_names(apps)}; name one with --application")
        return named
    used = {_key(app, use.path) for app in apps for use in (*app.libraries.values(), *app.types.values())}
    can = [app for app in apps if {"start", "stop"} <= app.programs.keys()]
    own = [app for app in can if f"{app.path}/{app.name}".lower() not in used] or can
    if len(own) != 1:
        raise DiskUnreadable(f"{len(own) or 'no'} applications can start: {_names(own or apps)}; name one with --application")
    return own[0]


def _key(app: Application, path: str) -> str:
    try:
        return "/".join(application_of(path, app.path)).lower()
    except PathFault:
        return ""


def _alters(apps: list[Application]) -> bool:
    """Whether the option alter is used."""
    lines = (line for app in apps for program in app.programs.values() for line in program.lines)
    return any("alterbegin" in line.partition("//")[0].lower() for line in lines)


def _names(apps: list[Application]) -> str:
    return ", ".join(app.name for app in apps[:20]) or "none that can be read"


def _family(app: Application) -> str:
    families = {declared.family for declared in app.data.values() if declared.family}
    return next(iter(families)) if len(families) == 1 else ""


def _unknown(card: Card, sockets: list[str]) -> list[str]:
    """Links of sio to nothing."""
    channels = [Channel(each.name, Kind.UDP) for each in card.channels]
    return [f"{link}: sio.cfx has no such channel; add a [[val3.channel]]" for link in sockets if channel_named(channels, link) is None]
