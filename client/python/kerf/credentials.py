"""Tokens and TLS: what the options of connect() and the environment name, read and checked."""

from __future__ import annotations

import ipaddress
import os
import ssl
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Optional, Tuple, Union

import grpc

FilePath = Union[str, "os.PathLike[str]"]

_MAX_TOKEN_BYTES = 4 << 10
_MAX_PEM_BYTES = 4 << 20  # the system's authorities have 0.2 MB
_SCHEMES = ("dns:///", "dns:", "ipv4:", "ipv6:")


@dataclass(frozen=True)
class Secrets:
    """Holds what a connection shows to its server, and whom it trusts."""

    token: str = field(default="", repr=False)  # empty: none
    use_tls: bool = False
    authorities: Optional[bytes] = field(default=None, repr=False)  # PEM; None: those of grpc
    certificate: Optional[bytes] = field(default=None, repr=False)  # PEM; None: none is shown
    key: Optional[bytes] = field(default=None, repr=False)  # PEM

    def channel_credentials(self) -> Any:
        """Returns the credentials of an encrypted channel."""
        return grpc.ssl_channel_credentials(self.authorities, self.key, self.certificate)

    def stub_channel(self, channel: Any) -> Any:
        """Returns the channel that stubs are made with; their calls carry the token."""
        return _TokenChannel(channel, self.token) if self.token else channel


def read_secrets(
    address: str,
    *,
    token: Optional[str],
    token_file: Optional[FilePath],
    tls: bool,
    tls_ca: Optional[FilePath],
    tls_cert: Optional[FilePath],
    tls_key: Optional[FilePath],
) -> Secrets:
    """Reads the files. Options that are None are taken from the environment, such as tls_ca from KERF_TLS_CA.

    Raises OSError if a file cannot be read, and ValueError if its content is unusable. Raises ValueError also if
    one of certificate and key is missing, or if the token would be sent to another machine in the clear. No message
    has a part of a token or of a key.
    """
    if token is not None and token_file is not None:
        raise ValueError("token_file: give a token or a file with one, not both")
    files = {}
    for option, value in (("token_file", token_file), ("tls_ca", tls_ca), ("tls_cert", tls_cert), ("tls_key", tls_key)):
        files[option] = _File.of(option, value)
    if token is not None:
        name, secret = "token", _token_in("token", token.encode())
    else:
        name, secret = files["token_file"].option, files["token_file"].token()
    certificate, key = files["tls_cert"], files["tls_key"]
    if certificate.path and not key.path:
        raise ValueError(f"{key.option}: a certificate is given without its key")
    if key.path and not certificate.path:
        raise ValueError(f"{certificate.option}: a key is given without its certificate")
    use_tls = bool(tls or files["tls_ca"].path or certificate.path)
    if secret and not use_tls and not is_on_this_machine(address):
        raise ValueError(
            f"{name}: the token is not sent to {address} in the clear, where others could read it: use TLS (tls=True or "
            "tls_ca), or a tunnel that begins at 127.0.0.1"
        )
    authorities = files["tls_ca"].pem("CERTIFICATE")
    if use_tls and authorities is None:
        authorities = _authorities_of_system()
    return Secrets(secret, use_tls, authorities, certificate.pem("CERTIFICATE"), key.pem("PRIVATE KEY"))


def is_on_this_machine(address: str) -> bool:
    """Returns True if this machine itself has the address: one of 127.0.0.0/8, ::1, localhost, or a unix socket."""
    if address.startswith(("unix:", "unix-abstract:")):
        return True
    for scheme in _SCHEMES:
        if address.startswith(scheme):
            return all(_is_loopback(_host_in(each)) for each in address.removeprefix(scheme).split(","))
    return _is_loopback(_host_in(address))


def _host_in(address: str) -> str:
    """Returns the host of HOST:PORT, [HOST]:PORT or a host alone; empty if the brackets are not closed before the port."""
    if address.startswith("["):
        host, bracket, port = address[1:].partition("]")
        return host if bracket and port[:1] in ("", ":") else ""
    return address.partition(":")[0] if address.count(":") == 1 else address


def _is_loopback(host: str) -> bool:
    if host.lower() == "localhost":
        return True
    try:
        number = ipaddress.ip_address(host)
    except ValueError:
        return False
    return number.is_loopback if number.version == 4 else number == ipaddress.IPv6Address("::1")


@dataclass(frozen=True)
class _File:
    """A file that an option names, or else a variable of the environment."""

    option: str  # as errors name it
    path: Optional[FilePath]  # None: no file

    @staticmethod
    def of(option: str, path: Optional[FilePath]) -> _File:
        if path is not None:
            return _File(option, path)
        variable = f"KERF_{option.upper()}"
        return _File(f"{option} ({variable})", os.environ.get(variable) or None)

    def read(self, max_bytes: int) -> bytes:
        assert self.path is not None
        try:
            with open(self.path, "rb") as file:
                content = file.read(max_bytes + 1)
        except OSError as failure:
            raise type(failure)(failure.errno, f"{self.option}: {failure.strerror}", str(self.path)) from None
        if len(content) > max_bytes:
            raise ValueError(f"{self.option}: {self.path} has more than {max_bytes} bytes")
        return content

    def token(self) -> str:
        return _token_in(self.option, self.read(_MAX_TOKEN_BYTES)) if self.path else ""

    def pem(self, label: str) -> Optional[bytes]:
        """Returns the content, which must have a part with the label; None without a file."""
        if not self.path:
            return None
        content = self.read(_MAX_PEM_BYTES)
        if b"ENCRYPTED" in content:
            raise ValueError(f"{self.option}: {self.path} is encrypted; give a key without a password")
        if b"-----BEGIN " not in content or label.encode() not in content:
            raise ValueError(f"{self.option}: {self.path} has no {label} in the form of PEM")
        return content


def _token_in(option: str, content: bytes) -> str:
    token = content.strip(b" \t\r\n")
    if not token:
        raise ValueError(f"{option}: the token is empty")
    if b"\n" in token:
        raise ValueError(f"{option}: there is more than one line; a token is one line")
    if not all(0x20 <= byte <= 0x7E for byte in token):
        raise ValueError(f"{option}: the token has characters other than printable ASCII")
    return token.decode("ascii")


def _authorities_of_system() -> Optional[bytes]:
    """Returns the authorities that the system trusts, because grpc's package brings a list of its own."""
    path = ssl.get_default_verify_paths().cafile
    if path is None or os.environ.get("GRPC_DEFAULT_SSL_ROOTS_FILE_PATH"):
        return None
    return _File("the system's authorities", path).read(_MAX_PEM_BYTES)


class _TokenChannel:
    """Makes the calls of stubs like the channel below it, with a token. It is the same for asyncio."""

    def __init__(self, channel: Any, token: str) -> None:
        self._channel = channel
        self._metadata: Tuple[Tuple[str, str], ...] = (("authorization", f"Bearer {token}"),)

    def unary_unary(self, *method: Any, **options: Any) -> Callable[..., Any]:
        return self._with_token(self._channel.unary_unary(*method, **options))

    def unary_stream(self, *method: Any, **options: Any) -> Callable[..., Any]:
        return self._with_token(self._channel.unary_stream(*method, **options))

    def stream_unary(self, *method: Any, **options: Any) -> Callable[..., Any]:
        return self._with_token(self._channel.stream_unary(*method, **options))

    def stream_stream(self, *method: Any, **options: Any) -> Callable[..., Any]:
        return self._with_token(self._channel.stream_stream(*method, **options))

    def _with_token(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(request: Any, *, metadata: Any = (), **options: Any) -> Any:
            return method(request, metadata=(*(metadata or ()), *self._metadata), **options)

        return call
