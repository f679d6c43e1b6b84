"""Debug adapter for BAPS2, ROBOTstar and VAL 3 programs: breakpoints, single step and variables in an editor, in virtual time."""

import argparse
import socket
import sys

from gateway.runtime.exit_codes import Exit
from gateway.tools.editor.dap import Adapter
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate dap                    started by an editor; uses standard input and output
  axisgate dap --tcp 4711         for one editor that connects to a port of this machine
  axisgate dap --tcp 4711 &       in the background; it ends with the session
launch arguments: program (path of a .QLL, .MPR, .SPR, .MAC, .pgx or .pjx file), stopOnEntry;
BAPS2: feed (inputs, points and devices, as axisgate program trace accepts it)
ROBOTstar: memory (folder S:/), mode (auto, test2, test4), plc, at (a list), until, as axisgate robotstar run accepts them
VAL 3: disk, robot, at (a list of "S WHAT=VALUE"), until, as axisgate val3 run accepts them
exit code: 0 done, 2 the port is taken or the command line is wrong"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate dap", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--tcp", type=_port, metavar="PORT", help="listen on 127.0.0.1 instead of standard input and output")
    options = parser.parse_args(argv)
    try:
        if options.tcp is None:
            Adapter(sys.stdin.fileno(), sys.stdout.buffer).serve()
        else:
            with socket.create_server(("127.0.0.1", options.tcp)) as server:
                connection, _ = server.accept()
            with connection, connection.makefile("wb") as writing:
                Adapter(connection.fileno(), writing).serve()
    except BrokenPipeError:
        return Exit.OK  # the editor is gone
    except OSError as error:
        complain("dap", error.strerror or error)
        return Exit.INVALID
    return Exit.OK


def _port(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 65535:
        raise argparse.ArgumentTypeError(f"{text}: 1 .. 65535")
    return value
