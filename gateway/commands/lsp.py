"""Language server for programs of the old controllers: errors while typing, outline, hover, definition."""

import argparse
import logging

from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate lsp                    started by an editor; uses standard input and output
  axisgate lsp --tcp 2087         for one editor that connects to a port of this machine
  axisgate lsp --log lsp.log      each message, for the case that the editor shows nothing
languages by suffix: BAPS2 .QLL; ROBOTstar .MPR .SPR .MAC .PAL .PLC; VAL 3 .pgx .pjx .dtx
needs the extra "editor": pip install 'axisgate[editor]'
exit code: 0 done, 2 the extra is not installed or the command line is wrong"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate lsp", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--tcp", type=_port, metavar="PORT", help="listen on 127.0.0.1 instead of standard input and output")
    parser.add_argument("--log", metavar="FILE", help="file for the messages of both sides")
    options = parser.parse_args(argv)
    if options.log is not None:
        try:
            logging.basicConfig(filename=options.log, level=logging.DEBUG, format="%(asctime)s %(name)s %(message)s")
        except OSError as error:
            complain("lsp", f"{options.log}: {error.strerror}")
            return Exit.INVALID
    try:
        from gateway.tools.editor.server import made_server
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        complain("lsp", "pygls is not installed; type: pip install 'axisgate[editor]'")
        return Exit.INVALID
    if options.tcp is None:
        made_server().start_io()
    else:
        made_server().start_tcp("127.0.0.1", options.tcp)
    return Exit.OK


def _port(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 65535:
        raise argparse.ArgumentTypeError(f"{text}: 1 .. 65535")
    return value
