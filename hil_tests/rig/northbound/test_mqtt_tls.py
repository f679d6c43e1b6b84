"""MQTT inside TLS with a password, against mosquitto: who the authority of the cell did not sign hears nothing (AX-428)."""

import asyncio
import contextlib
import dataclasses
import datetime
import importlib
import ipaddress
import json
import pathlib
import shutil
import socket
import ssl
import subprocess
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from gateway.northbound.mqtt import MqttOut
from gateway.pure.cell.northbound import NorthMqtt
from hil_tests.lab.running.cell_running import free_port

paho: Any = importlib.import_module("paho.mqtt.client")
MOSQUITTO = shutil.which("mosquitto") or "/usr/sbin/mosquitto"
PASSWORDS = shutil.which("mosquitto_passwd") or "/usr/bin/mosquitto_passwd"
LIMIT_S = 30.0


def authority(folder: pathlib.Path, name: str) -> None:
    """NAME.pem signs NAME-broker.pem, whose key is NAME-broker.key: a broker on 127.0.0.1."""
    keys = [ec.generate_private_key(ec.SECP256R1()) for _ in range(2)]
    subjects = [x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)]) for text in (name, f"{name}-broker")]
    now = datetime.datetime.now(datetime.UTC)
    for number, subject in enumerate(subjects):
        builder = (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(subjects[0])
            .public_key(keys[number].public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - datetime.timedelta(days=1))
            .not_valid_after(now + datetime.timedelta(days=1))
            .add_extension(x509.BasicConstraints(ca=number == 0, path_length=None), critical=True)
            .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), critical=False)
        )
        certificate = builder.sign(keys[0], hashes.SHA256())
        stem = folder / (name if number == 0 else f"{name}-broker")
        stem.with_suffix(".pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
        plain = serialization.NoEncryption()
        stem.with_suffix(".key").write_bytes(
            keys[number].private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, plain)
        )


@pytest.fixture
def broker(tmp_path: pathlib.Path) -> Iterator[int]:
    """mosquitto that listens inside TLS only and wants a password; its port."""
    authority(tmp_path, "plant")
    port = free_port()
    (tmp_path / "users").touch(mode=0o600)
    subprocess.run([PASSWORDS, "-b", str(tmp_path / "users"), "gateway", "a secret"], check=True, capture_output=True)
    (tmp_path / "password").write_text("a secret\n")
    (tmp_path / "mosquitto.conf").write_text(
        f"listener {port} 127.0.0.1\nallow_anonymous false\npassword_file {tmp_path}/users\nuser {tmp_path.owner()}\n"
        f"cafile {tmp_path}/plant.pem\ncertfile {tmp_path}/plant-broker.pem\nkeyfile {tmp_path}/plant-broker.key\n"
    )
    process = subprocess.Popen([MOSQUITTO, "-c", str(tmp_path / "mosquitto.conf")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield port
    finally:
        process.kill()
        process.wait()


async def until(holds: Callable[[], object], what: str) -> None:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(LIMIT_S):
            while not holds():
                await asyncio.sleep(0.02)
    assert holds(), f"not within {LIMIT_S:g} s: {what}"


def listens(port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1):
        return True
    return False


def test_values_go_out_inside_tls_and_nobody_else_is_believed(broker: int, tmp_path: pathlib.Path) -> None:
    authority(tmp_path, "elsewhere")
    heard: list[dict[str, Any]] = []

    async def play() -> None:
        loop = asyncio.get_running_loop()
        await until(lambda: listens(broker), "mosquitto listens")
        eyes = paho.Client(paho.CallbackAPIVersion.VERSION2)
        eyes.tls_set(ca_certs=str(tmp_path / "plant.pem"), cert_reqs=ssl.CERT_REQUIRED)
        eyes.username_pw_set("gateway", "a secret")
        subscribed: list[int] = []
        eyes.on_connect = lambda client, *_: client.subscribe("plant/hall3/values", qos=1)
        eyes.on_subscribe = lambda *_: subscribed.append(1)
        eyes.on_message = lambda _client, _userdata, message: heard.append(json.loads(message.payload))
        eyes.connect("127.0.0.1", broker)
        eyes.loop_start()
        await until(lambda: subscribed, "the subscriber")
        settings = NorthMqtt(f"127.0.0.1:{broker}", "plant", user="gateway", password_file="password")
        secured = [dataclasses.replace(settings, tls_ca=f"{ca}.pem") for ca in ("plant", "elsewhere")]
        outs = [MqttOut(each, "hall3", tmp_path, loop) for each in secured]
        plain = MqttOut(settings, "hall3", tmp_path, loop)
        try:
            for out in (*outs[1:], plain, outs[0]):
                out.start()
                out.publish({"cell.life": 7 if out is outs[0] else 8})
            await until(lambda: heard, "the value")
            assert outs[0].connected and not outs[1].connected and not plain.connected
            assert [message["values"] for message in heard] == [{"cell.life": 7}]
        finally:
            for out in (*outs, plain):
                out.close()
            eyes.disconnect()
            eyes.loop_stop()

    asyncio.run(play())
