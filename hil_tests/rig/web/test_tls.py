"""The page over TLS, read-only: encrypted, marked as such, and nothing but stop is changed."""

import datetime
import http.client
import json
import pathlib
import ssl
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from gateway.files.find import find_config
from hil_tests.lab.running.cell_running import P5_MS, free_port, running_cell
from hil_tests.lab.running.web_running import until

pytestmark = pytest.mark.slow


def certificate(folder: pathlib.Path) -> None:
    """web.pem and web.key of "localhost", signed by itself."""
    key, name = ec.generate_private_key(ec.SECP256R1()), x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "localhost")])
    now = datetime.datetime.now(datetime.UTC)
    made = (
        x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key()).serial_number(1)
        .not_valid_before(now - datetime.timedelta(days=1)).not_valid_after(now + datetime.timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), critical=False).sign(key, hashes.SHA256())
    )  # fmt: skip
    (folder / "web.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    clear = serialization.NoEncryption()
    (folder / "web.key").write_bytes(key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, clear))


def test_a_read_only_page_over_tls(tmp_path: pathlib.Path) -> None:
    certificate(tmp_path)
    port = free_port()
    cell = tmp_path / "cell.toml"
    web = f'\n[web]\nbind = "127.0.0.1:{port}"\nread_only = true\ntls_certificate = "web.pem"\ntls_key = "web.key"\n'
    cell.write_text(find_config("demo", "cells").read_text() + web)
    trusted = ssl.create_default_context(cafile=str(tmp_path / "web.pem"))

    def ask(method: str, path: str, body: object = None) -> tuple[int, Any, dict[str, str]]:
        link = http.client.HTTPSConnection("localhost", port, timeout=20, context=trusted)
        headers = {"x-axisgate": "1", "content-type": "application/json"}
        link.request(method, path, None if body is None else json.dumps(body), headers)
        answer = link.getresponse()
        told = json.loads(answer.read())
        link.close()
        return answer.status, told, {name.lower(): value for name, value in answer.getheaders()}

    def up() -> bool:
        try:
            return ask("GET", "/api/health")[0] == 200
        except OSError:
            return False

    with running_cell(str(cell), "tls", plc=False, p5_ms=max(10, P5_MS)):
        until(up, "the page answers over TLS")
        status, told, headers = ask("GET", "/api/me")
        assert (status, told["read_only"]) == (200, True)
        assert headers["strict-transport-security"].startswith("max-age=")
        assert "default-src 'self'" in headers["content-security-policy"]
        assert ask("POST", "/api/cable", {"line": "plc1", "do": "unplug"})[0] == 403
        status, _, headers = ask("POST", "/api/setup", {"name": "anna", "password": "long enough 1"})
        assert status == 200, "who looks from elsewhere has to be able to log in"
        assert "secure" in headers["set-cookie"].lower()
        assert ask("POST", "/api/stop")[0] == 200
        with pytest.raises((OSError, http.client.HTTPException)):
            in_the_clear(port)


def in_the_clear(port: int) -> None:
    link = http.client.HTTPConnection("127.0.0.1", port, timeout=5)
    link.request("GET", "/api/me")
    link.getresponse()
