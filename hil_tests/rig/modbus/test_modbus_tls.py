"""Modbus/TCP Security: certificates on both sides, roles out of them, rights by role.  The test makes its own certificates."""

import asyncio
import datetime
import json
import pathlib
import socket
import ssl
import struct
from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from drivers.ports.base import PortError
from gateway.links.modbus.client import Device, Link, ModbusClient, ModbusRefused
from gateway.links.modbus.tls import ROLE_OID, TlsRights, client_context, role_of, server_context
from gateway.pure.cell.modbus import Modbus, ModbusRole, ModbusTls
from gateway.runtime.journal import Journal
from gateway.services.modbus_clients import secured
from gateway.services.sources.modbus import Refusals, role_rights
from hil_tests.lab.running.modbus_running import Running
from protocols.modbus.view import Kind

READ, WRITE = "03 0000 0001", "06 0000 1234"
ROLES = (ModbusRole("viewer"), ModbusRole("operator", write=True, holding=("0..9",), coils=()), ModbusRole("engineer", write=True))


@dataclass
class Authority:
    """Signs; everything lies in one folder."""

    folder: pathlib.Path
    name: str

    def __post_init__(self) -> None:
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._certificate = self._signed(self.name, self._key, self.name, None, ca=True)
        self._write(f"{self.name}.pem", self._certificate.public_bytes(serialization.Encoding.PEM))

    def issue(self, name: str, role: str | bytes | None = None) -> ModbusTls:
        """A certificate with this role; the files for one side that believes this authority."""
        key = ec.generate_private_key(ec.SECP256R1())
        certificate = self._signed(name, key, self.name, role, ca=False)
        self._write(f"{name}.pem", certificate.public_bytes(serialization.Encoding.PEM))
        plain = serialization.NoEncryption()
        self._write(f"{name}.key", key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, plain))
        return ModbusTls(f"{name}.pem", f"{name}.key", f"{self.name}.pem")

    def _signed(self, name: str, key: ec.EllipticCurvePrivateKey, issuer: str, role: str | bytes | None, *, ca: bool) -> x509.Certificate:
        def named(text: str) -> x509.Name:
            return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])

        now = datetime.datetime.now(datetime.UTC)
        builder = (
            x509.CertificateBuilder()
            .subject_name(named(name))
            .issuer_name(named(issuer))
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - datetime.timedelta(days=1))
            .not_valid_after(now + datetime.timedelta(days=1))
            .add_extension(x509.BasicConstraints(ca=ca, path_length=None), critical=True)
        )
        if role is not None:
            data = role if isinstance(role, bytes) else bytes((0x0C, len(role.encode()))) + role.encode()
            builder = builder.add_extension(x509.UnrecognizedExtension(x509.ObjectIdentifier(ROLE_OID), data), critical=False)
        return builder.sign(self._key, hashes.SHA256())

    def _write(self, name: str, data: bytes) -> None:
        (self.folder / name).write_bytes(data)


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Authority:
    return Authority(tmp_path_factory.mktemp("tls"), "plant")


@pytest.fixture
def running(plant: Authority) -> Iterator[Running]:
    context = server_context(plant.issue("server"), plant.folder)
    with Running(tls=context, rights_for=TlsRights({role.role: role_rights(role) for role in ROLES})) as server:
        yield server


def connect(running: Running, context: ssl.SSLContext) -> ssl.SSLSocket:
    return context.wrap_socket(socket.create_connection(("127.0.0.1", running.port), timeout=10))


def ask(connection: ssl.SSLSocket, pdu: str) -> str:
    body = bytes.fromhex(pdu)
    connection.sendall(struct.pack(">HHHB", 1, 0, len(body) + 1, 1) + body)
    return connection.recv(300)[7:].hex(" ").upper()


@pytest.mark.parametrize(
    "role, read, write, write_20",
    [
        ("viewer", "03 02 00 00", "86 01", "86 01"),
        ("operator", "03 02 00 00", "06 00 00 12 34", "86 02"),
        ("engineer", "03 02 00 00", "06 00 00 12 34", "06 00 14 12 34"),
        ("stranger", "83 01", "86 01", "86 01"),
        (None, "83 01", "86 01", "86 01"),
    ],
)
def test_rights_go_by_the_role(running: Running, plant: Authority, role: str | None, read: str, write: str, write_20: str) -> None:
    with connect(running, client_context(plant.issue(f"client-{role}", role), plant.folder)) as connection:
        assert ask(connection, READ) == read
        assert ask(connection, WRITE) == write
        assert ask(connection, "06 0014 1234") == write_20
        assert ask(connection, "05 0000 FF00") == ("05 00 00 FF 00" if role == "engineer" else "85 02" if role == "operator" else "85 01")
        assert running.server.clients[0].role == (role or "")
    assert running.view.words[Kind.HOLDING_REGISTERS][0] == (0x1234 if role in ("operator", "engineer") else 0)


def test_without_a_certificate_nobody_is_heard(running: Running, plant: Authority) -> None:
    bare = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    bare.check_hostname = False
    bare.load_verify_locations(plant.folder / "plant.pem")
    with pytest.raises(OSError):
        ask_or_die(running, bare)
    assert running.server.counters.requests == 0


def test_a_certificate_of_another_authority_is_worth_nothing(running: Running, plant: Authority) -> None:
    stranger = Authority(plant.folder, "elsewhere").issue("intruder", "engineer")
    settings = ModbusTls(stranger.certificate, stranger.key, "plant.pem")
    with pytest.raises(OSError):
        ask_or_die(running, client_context(settings, plant.folder))
    assert running.server.counters.requests == 0


def ask_or_die(running: Running, context: ssl.SSLContext) -> None:
    """With TLS 1.3 the refusal comes with the first bytes, not with the handshake."""
    with connect(running, context) as connection:
        answer = ask(connection, READ)
        raise OSError("closed") if not answer else AssertionError(f"answered {answer}")


def test_the_client_does_not_speak_with_a_server_of_another_authority(running: Running, plant: Authority) -> None:
    Authority(plant.folder, "other")
    mine = plant.issue("careful", "engineer")
    with pytest.raises(ssl.SSLCertVerificationError):
        connect(running, client_context(ModbusTls(mine.certificate, mine.key, "other.pem"), plant.folder))


def test_tls_1_1_and_plain_modbus_are_turned_away(running: Running, plant: Authority) -> None:
    with running.client() as plain:
        plain.send(bytes.fromhex("0001 0000 0006 01 03 0000 0001"))
        assert b"\x03\x02" not in plain.take(20)
    assert server_context(plant.issue("again"), plant.folder).minimum_version == ssl.TLSVersion.TLSv1_2


@pytest.mark.parametrize("data", [b"", b"\x0c", b"\x0c\x05ab", b"\x13\x08operator", b"\x0c\x08operator!"])
def test_a_role_that_cannot_be_read_is_none(plant: Authority, data: bytes) -> None:
    plant.issue("odd", data)
    certificate = x509.load_pem_x509_certificate((plant.folder / "odd.pem").read_bytes())
    assert role_of(certificate.public_bytes(serialization.Encoding.DER)) == ""
    assert role_of(b"no certificate") == ""


def test_a_missing_file_is_named(plant: Authority) -> None:
    with pytest.raises(PortError, match=r"absent\.pem"):
        server_context(ModbusTls("absent.pem", "absent.key", "plant.pem"), plant.folder)


def test_a_client_of_a_cell_asks_inside_tls_and_may_what_its_role_may(plant: Authority) -> None:
    settings = Modbus("coupler", role="client", port_="tcp://127.0.0.1:802", tls=plant.issue("cell", "operator"))

    async def play(running: Running) -> int:
        url = f"tcp://127.0.0.1:{running.port}"
        client = ModbusClient(Link(url), [Device("tank")], None, secured(settings, url, plant.folder))
        client.start()
        try:
            async with asyncio.timeout(30):
                while not client.connected:
                    await asyncio.sleep(0.01)
                await client.write_words("tank", 3, [0x1234])
                assert running.view.words[Kind.HOLDING_REGISTERS][3] == 0x1234
                with pytest.raises(ModbusRefused) as refused:
                    await client.write_words("tank", 20, [1])
                running.view.words[Kind.HOLDING_REGISTERS][:120] = list(range(120))
                answers = await asyncio.gather(*(client.read("tank", Kind.HOLDING_REGISTERS, 0, 120) for _ in range(20)))
                assert set(answers) == {tuple(range(120))}
                return refused.value.code
        finally:
            client.close()

    rights = TlsRights({role.role: role_rights(role) for role in ROLES})
    with Running(tls=server_context(plant.issue("coupler"), plant.folder), rights_for=rights) as server:
        assert asyncio.run(play(server)) == 2


def test_a_client_whose_server_is_of_another_authority_says_so(running: Running, plant: Authority) -> None:
    Authority(plant.folder, "foreign")
    mine = plant.issue("wary", "engineer")
    settings = Modbus("coupler", role="client", tls=ModbusTls(mine.certificate, mine.key, "foreign.pem"))
    opened = secured(settings, f"tcp://127.0.0.1:{running.port}", plant.folder)
    assert opened is not None
    with pytest.raises(PortError, match="both sides need certificates"):
        opened()


def test_who_fails_the_handshake_is_in_the_journal_once_a_minute(running: Running, plant: Authority, tmp_path: pathlib.Path) -> None:
    journal = Journal(tmp_path / "journal", "services")
    running.server.on_refused = Refusals("plc2", journal.write).heard

    def told() -> list[str]:
        return [json.loads(line)["text"] for line in (tmp_path / "journal").read_text().splitlines()]

    stranger = Authority(plant.folder, "abroad").issue("spy", "engineer")
    for _ in range(3):
        with pytest.raises(OSError):
            ask_or_die(running, client_context(ModbusTls(stranger.certificate, stranger.key, "plant.pem"), plant.folder))
    running.until(lambda: len(told()) == 1, "the refusal")
    assert told()[0].startswith("plc2: TLS client 127.0.0.1 is refused: ") and "verify failed" in told()[0]
    assert told()[0].endswith("check its certificate, key and CA")
    with connect(running, client_context(plant.issue("welcome", "viewer"), plant.folder)) as connection:
        assert ask(connection, READ) == "03 02 00 00", "others are served as before"
    assert len(told()) == 1
