"""Manage users of the page without a browser: add, remove, list, change a password."""

import argparse
import getpass
import json
import sqlite3
import sys

from gateway.pure.cell.web import Web
from gateway.runtime.page_data import data_file
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING
from gateway.tools.usage_language import complain
from gateway.web.store import Role, Store, StoreError

EXAMPLES = """examples:
  axisgate web user add cell.toml anna --role admin          asks for the password twice
  printf '%s' "$PASSWORD" | axisgate web user password cell.toml anna --stdin
  axisgate web user list cell.toml --json
  axisgate web user remove cell.toml bert
A password is never an argument: others of this computer could read it.  --sim: of the simulated run, whose users are kept apart.
exit code: 0 done, 1 refused (no such user, a weak password, the last administrator), 2 command line or cell, 3 the file cannot be used"""
ROLES = ("viewer", "operator", "setter", "admin")


def main(argv: list[str]) -> int:
    arguments = make_parser().parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    path = data_file(cell, cell.web or Web(), simulated=arguments.sim)
    password = ""
    if arguments.do in ("add", "password"):
        typed = _password(arguments.stdin)
        if typed is None:
            return _said("the two passwords differ; nothing was changed", FINDING)
        password = typed
    try:
        store = Store(path)
    except (OSError, sqlite3.Error) as error:
        return _said(f"{path}: {error}; run it as the user of the gateway", ENVIRONMENT)
    try:
        return _done(store, arguments, password)
    except StoreError as error:
        return _said(f"{error}; next: axisgate web user list {arguments.cell}", FINDING)
    except sqlite3.Error as error:
        return _said(f"{path}: {error}", ENVIRONMENT)
    finally:
        store.close()


def make_parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("axisgate web", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    things = parser.add_subparsers(dest="thing", required=True, metavar="user")
    user = things.add_parser("user", help="users of the page", description=__doc__, epilog=EXAMPLES, formatter_class=raw)
    does = user.add_subparsers(dest="do", required=True, metavar="DO")
    for name, text in (("add", "a new user"), ("password", "a new password; sessions end"), ("remove", "a user leaves"), ("list", "all")):
        tool = does.add_parser(name, help=text)
        tool.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
        if name != "list":
            tool.add_argument("name", metavar="NAME")
        if name == "add":
            tool.add_argument("--role", choices=ROLES, required=True, help="each includes the rights of those before it")
        if name in ("add", "password"):
            tool.add_argument("--stdin", action="store_true", help="the password is read from standard input, without asking")
        tool.add_argument("--sim", action="store_true", help="users of the simulated run of this cell")
        tool.add_argument("--json", action="store_true", help="the users afterwards as JSON")
    return parser


def _password(piped: bool) -> str | None:
    """From standard input, or typed twice; None: the two differ."""
    if piped:
        return sys.stdin.readline().rstrip("\r\n")
    first = getpass.getpass("password: ")
    return first if getpass.getpass("once more: ") == first else None


def _done(store: Store, arguments: argparse.Namespace, password: str) -> int:
    """Carried out, noted in the audit, reported.  StoreError."""
    users = dict(store.users())
    name = "" if arguments.do == "list" else arguments.name
    if arguments.do == "add" and name in users:
        return _said(f"{name} exists already; next: axisgate web user password {arguments.cell} {name}", FINDING)
    if arguments.do in ("password", "remove") and name not in users:
        return _said(f"no user {name}; there are {', '.join(users) or 'none'}; next: axisgate web user list {arguments.cell}", FINDING)
    match arguments.do:
        case "add":
            store.put_user(name, Role[arguments.role.upper()], password)
        case "password":
            store.put_user(name, users[name], password)
        case "remove":
            store.drop_user(name)
    if arguments.do != "list":
        store.note(f"command line ({getpass.getuser()})", "local", f"web user {arguments.do}", {"name": name})
    _print_users(store, arguments)
    return DONE


def _print_users(store: Store, arguments: argparse.Namespace) -> None:
    rows = [{"name": name, "role": role.name.lower()} for name, role in store.users()]
    if arguments.json:
        print(json.dumps({"file": str(store.path), "users": rows}))
    elif arguments.do == "list":
        print("\n".join(f"{row['name']:<24} {row['role']}" for row in rows) or f"no user yet ({store.path})")
    else:
        print(f"{arguments.name}: {arguments.do} done ({store.path})")


def _said(words: str, code: int) -> int:
    complain("web user", words)
    return code
