"""Show a running cell in the terminal: axes, signals, lines and errors live, or the pendant of the old controller."""

import argparse
import asyncio
import json
import sys

from gateway.commands.var import runs_up
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.monitor.look import FILTERS, TABS, Look, NoRun
from gateway.tools.monitor.tables import Table, as_json, plain
from gateway.tools.runs import not_chosen
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate monitor                                  the active run; ? shows the keys
  axisgate monitor demo --tab errors --once         pending errors with cause and remedy, as plain text
  axisgate monitor demo --tab signals --search "DB10 target" --json | jq .signals
  axisgate monitor old --pendant                    the pendant of a rho 3 or a ROBOTstar V: display and keys
  axisgate monitor old --press "MODE 7.3.2 ENTER"   keys, then what the display shows
  axisgate monitor reis --press "RUN F2 START"      of a ROBOTstar V: Test 2, then START
If the output is not a terminal: one snapshot as plain text without colours, as with --once.
exit code: 0 done, 1 refused by the pendant, 2 command line, 3 no such run"""


def main(argv: list[str]) -> int:
    arguments = make_parser().parse_args(argv)
    up = runs_up()
    name = arguments.run or (up[0] if len(up) == 1 else "")
    if name not in up:
        complain("monitor", not_chosen(name, up, f"axisgate monitor {up[0]}" if up else ""))
        return ENVIRONMENT
    if arguments.pendant or arguments.press:
        return _pendant(name, arguments)
    look = Look(name, arguments.lang or "")
    look.search, look.filter = arguments.search, arguments.filter
    once = arguments.once or arguments.json or not sys.stdout.isatty()
    try:
        if once:
            return asyncio.run(_once(look, arguments.tab or ("all" if not arguments.search else "signals"), as_text=not arguments.json))
        return asyncio.run(_live(look, arguments.tab or "axes"))
    except NoRun as gone:
        complain("monitor", gone)
        return ENVIRONMENT
    except KeyboardInterrupt:
        return DONE


def make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "axisgate monitor", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", nargs="?", metavar="RUN", help="name of the run, if several are active")
    parser.add_argument(
        "--tab", choices=(*TABS, "all"), help="the tab to begin with; with --once what is printed (default all but signals)"
    )
    parser.add_argument("--search", default="", metavar="WORDS", help="signals: every word must occur in a name, address, text or use")
    parser.add_argument("--filter", choices=FILTERS, default="all", help="signals: only these (default %(default)s)")
    parser.add_argument("--pendant", action="store_true", help="the pendant of the old controller instead of the tabs")
    parser.add_argument("--press", default="", metavar="KEYS", help='at the pendant, then its display: "MODE 7.1 ENTER", "INFO", "DOWN"')
    parser.add_argument("--once", action="store_true", help="one snapshot as plain text, then end")
    parser.add_argument("--json", action="store_true", help="one snapshot as a JSON object")
    parser.add_argument("--lang", choices=("de", "en"), help="of causes and remedies (default: the cell's)")
    return parser


def _pendant(run: str, arguments: argparse.Namespace) -> int:
    """On the screen, or keys and one display."""
    from gateway.observer.tool_link import Gone
    from gateway.tools.monitor.pendant import PanelError, Pendant, framed, once

    try:
        if not (arguments.press or arguments.once or arguments.json) and sys.stdout.isatty():
            asyncio.run(Pendant(run).run_async())
            return DONE
        shown = asyncio.run(once(run, arguments.press))
    except ValueError as error:
        complain("monitor", f"--press: {error}")
        return USAGE
    except PanelError as error:
        complain("monitor", f"{error}; next: axisgate monitor {run}")
        return FINDING
    except Gone as error:
        complain("monitor", f"{error}; axisgate run CELL --sim starts one")
        return ENVIRONMENT
    except KeyboardInterrupt:
        return DONE
    print(
        json.dumps(shown, ensure_ascii=False)
        if arguments.json
        else f"{framed(shown['screen'], shown['unit']['columns'])}\nmode {shown['mode']}"
    )
    return DONE


async def _once(look: Look, tab: str, *, as_text: bool) -> int:
    """Plain tables, or one object."""
    await look.attach()
    await look.still()
    wanted = [each for each in TABS if each != "signals"] if tab == "all" else [tab]
    shown: dict[str, Table] = {}
    for each in wanted:
        found = await look.table(each)
        shown |= {"command_sources": found[0], "said": found[1]} if each == "lines" else {each: found[0]}
    if as_text:
        print("\n\n".join([look.head(), *map(plain, shown.values())]))
    else:
        print(as_json(shown, look.figures()))
    look.close()
    return DONE


async def _live(look: Look, tab: str) -> int:
    from gateway.tools.monitor.app import Monitor  # Textual, where there is a screen

    if tab == "all":
        complain("monitor", "--tab all is for --once; next: axisgate monitor --once --tab all")
        return USAGE
    await look.attach()
    await Monitor(look, tab).run_async()
    look.close()
    return DONE
