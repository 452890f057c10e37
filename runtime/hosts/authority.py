"""The authority of one run: it signs the keys of the run's processes, and is gone with the run.

Nobody else's certificate is worth anything in the run, and this one's are worth nothing in another. So dates decide
nothing, and hosts whose clocks differ understand each other.
"""

import datetime
import hashlib
import os
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from formation.errors import EchelonError
from network.access.keys import AUTHORITY

_FROM, _UNTIL = datetime.datetime(2000, 1, 1), datetime.datetime(2100, 1, 1)
_CURVE = ec.SECP256R1()
_PEM = serialization.Encoding.PEM


class Authority:
    """Signs for one run. Its own key is in memory only."""

    def __init__(self) -> None:
        self._key = ec.generate_private_key(_CURVE)
        name = _name("echelon run")
        self._certificate = (
            _builder(name, name, self._key.public_key())
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .sign(self._key, hashes.SHA256())
        )

    @property
    def pem(self) -> str:
        """Its certificate."""
        return self._certificate.public_bytes(_PEM).decode()

    def sign(self, request: str, names: list[str]) -> dict[str, str]:
        """A certificate for the key of a signing request under each of these common names.

        Raises:
            EchelonError: it is no signing request, or of a kind of key that is not used here.
        """
        try:
            asked = x509.load_pem_x509_csr(request.encode())
            key = asked.public_key()
            valid = asked.is_signature_valid
        except Exception as error:  # whatever the library makes of a stranger's bytes
            raise EchelonError(f"expected a signing request; {type(error).__name__}") from None
        if not (valid and isinstance(key, ec.EllipticCurvePublicKey) and key.curve.name == _CURVE.name):
            raise EchelonError(f"expected a signing request for a key on {_CURVE.name}")
        return {name: self._signed(name, key) for name in names}

    def write(self, folder: Path, *names: str) -> None:
        """Make keys for these common names in a folder that is made if it is not there; "router" is the server's."""
        write_private(folder / AUTHORITY, self.pem)
        for name in names:
            key = ec.generate_private_key(_CURVE)
            write_private(folder / f"{name}.key", private(key))
            write_private(folder / f"{name}.pem", self._signed(name, key.public_key()))

    def _signed(self, name: str, key: ec.EllipticCurvePublicKey) -> str:
        usage = ExtendedKeyUsageOID.SERVER_AUTH if name == "router" else ExtendedKeyUsageOID.CLIENT_AUTH
        certificate = (
            _builder(_name(name), self._certificate.subject, key)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.SubjectAlternativeName([x509.DNSName(name)]), critical=False)
            .add_extension(x509.ExtendedKeyUsage([usage]), critical=True)
            .sign(self._key, hashes.SHA256())
        )
        return certificate.public_bytes(_PEM).decode()


def new_request() -> tuple[str, str]:
    """A new private key, and a signing request for it."""
    key = ec.generate_private_key(_CURVE)
    asked = x509.CertificateSigningRequestBuilder().subject_name(_name("whatever is signed")).sign(key, hashes.SHA256())
    return private(key), asked.public_bytes(_PEM).decode()


def fingerprint(pem: str, length: int) -> bytes:
    """So many bytes that hardly any other certificate has; to look for one takes 20 ms a try."""
    try:
        encoded = x509.load_pem_x509_certificate(pem.encode()).public_bytes(serialization.Encoding.DER)
    except ValueError:
        raise EchelonError("expected a certificate") from None
    return hashlib.scrypt(encoded, salt=b"echelon", n=1 << 13, r=8, p=1, dklen=length)


def private(key: ec.EllipticCurvePrivateKey) -> str:
    """The key as a file has it."""
    return key.private_bytes(_PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()).decode()


def write_private(path: Path, text: str) -> None:
    """Write a file that only this user can read, in a folder that only this user can enter."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
        os.fchmod(file.fileno(), 0o600)
        file.write(text)


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def _builder(subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(_FROM)
        .not_valid_after(_UNTIL)
    )
