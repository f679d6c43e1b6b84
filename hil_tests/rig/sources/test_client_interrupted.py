"""A Ctrl-C within a request: the client ends the exchange first, so the next request gets its own answer."""

import json
import pathlib
import signal
import socket
import threading
import time

import pytest

from gateway.tools.client import ToolClient

LATE_S = 0.2  # the interrupt is there first


def test_a_request_behind_an_interrupted_one_gets_its_own_answer(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gateway.tools.client.runtime_dir", lambda: tmp_path)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as source:
        source.bind(str(tmp_path / "cell-services.sock"))
        source.listen()
        server = threading.Thread(target=interrupts_the_first, args=(source,))
        server.start()
        client = ToolClient("cell")
        with pytest.raises(KeyboardInterrupt):
            client.ask("first")
        answer = client.ask("second")
        client.close()
        server.join()
    assert answer == {"op": "second"}


def interrupts_the_first(source: socket.socket) -> None:
    """Answer each request with its name; a Ctrl-C comes while the client waits for the first answer."""
    link, _ = source.accept()
    with link, link.makefile("rb") as requests:
        for number, line in enumerate(requests):
            if number == 0:
                signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
                time.sleep(LATE_S)
            link.sendall(json.dumps({"op": json.loads(line)["op"]}).encode() + b"\n")
