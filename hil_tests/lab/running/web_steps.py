"""Longer steps on a page with a logged-in user: orders besides its own keys, a token for a script, requests of a stranger."""

import subprocess
import sys

from playwright.sync_api import Page

from hil_tests.lab.running.web_running import WebRun

TOKEN = """async () => { const me = await (await fetch('/api/me')).json();
const answer = await fetch('/api/tokens', {method: 'POST', body: '{"label": "fuzz", "role": "admin"}',
  headers: {'content-type': 'application/json', 'x-axisgate-csrf': me.csrf}}); return (await answer.json()).token; }"""
SHAPE = ["--checks", "not_a_server_error", "--seed", "1", "--max-examples", "3", "--request-timeout", "20"]
PHASES = ["--exclude-path", "/api/logout", "--phases", "fuzzing", "--warnings", "off", "--no-color", "--no-shrink"]


class Orders:
    """Commands with the page's own session."""

    def __init__(self, web: WebRun, page: Page) -> None:
        self._web = web
        self._csrf = page.evaluate("fetch('/api/me').then(r => r.json())")["csrf"]
        self._cookie = "; ".join(f"{each.get('name')}={each.get('value')}" for each in page.context.cookies())

    def refused(self, code: str, mask: int, **more: object) -> str:
        """Why it was refused or ended at once, in the word of its reason; "" when it was neither."""
        body = {"code": code, "mask": mask, **more}
        status, told = self._web.ask("POST", "/api/command", body, cookie=self._cookie, x_axisgate_csrf=self._csrf)
        assert status == 200, told
        return str(told["words"]) if told["state"] in ("REFUSED", "ABORTED") else ""


def schemathesis(web: WebRun, page: Page) -> "subprocess.CompletedProcess[str]":
    """What we did not write asks everything the interface describes, as an administrator's script."""
    token = page.evaluate(TOKEN)
    command = [sys.executable, "-m", "schemathesis.cli", "run", f"{web.url}/api/openapi.json", "--header", f"authorization: Bearer {token}"]
    return subprocess.run([*command, *SHAPE, *PHASES], capture_output=True, text=True, timeout=100, check=False)
