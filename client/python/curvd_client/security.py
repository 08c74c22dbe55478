"""How a client knows its server, and shows who it is."""

from __future__ import annotations

import dataclasses
import functools
import os
import pathlib
import re
import ssl
import typing

import grpc

from curvd_client.addresses import is_local

_CERTIFICATE = re.compile(rb"-----BEGIN (?:\w+ )?CERTIFICATE-----.*?-----END (?:\w+ )?CERTIFICATE-----", re.DOTALL)
_MOST_TOKEN_BYTES = 4096

_TEXT, _FILE = (str, type(None)), (str, os.PathLike, type(None))
_FIELD_TYPES: dict[str, tuple[tuple[type, ...], str]] = {
    "tls": ((bool,), "True or False"),
    "ca_file": (_FILE, "a str, a path or None"),
    "cert_file": (_FILE, "a str, a path or None"),
    "key_file": (_FILE, "a str, a path or None"),
    "server_name": (_TEXT, "a str or None"),
    "token": (_TEXT, "a str or None"),
    "send_token_in_plain_text": ((bool,), "True or False"),
}

_Options = typing.Sequence[typing.Tuple[str, typing.Any]]


@dataclasses.dataclass(frozen=True)
class Security:
    """What a connection needs where servers do not take calls of everybody in plain text.

    tls:                 encrypt, and check the server's certificate; implied by ca_file and cert_file.
    ca_file:             PEM file of the authorities that the server's certificate may be of. DEFAULT: gRPC's own.
    cert_file, key_file: PEM files of the certificate that the client shows, and of its private key.
    server_name:         name to find in the server's certificate. DEFAULT: the host in the address.
    token:               bearer token, sent with each call: printable ASCII without blanks, at most 4096 bytes; "" is none.
    send_token_in_plain_text: whether the token may go to other machines without TLS.

    Raises TypeError, naming the field, for a value of another type, which it does not show: it may be the token.
    """

    tls: bool = False
    ca_file: str | os.PathLike[str] | None = None
    cert_file: str | os.PathLike[str] | None = None
    key_file: str | os.PathLike[str] | None = None
    server_name: str | None = None
    token: str | None = dataclasses.field(default=None, repr=False)
    send_token_in_plain_text: bool = False

    def __post_init__(self) -> None:
        for name, (types, words) in _FIELD_TYPES.items():
            value = getattr(self, name)
            if not isinstance(value, types):
                raise TypeError(f"{name} of Security is of type {type(value).__name__}; it must be {words}")

    def open_channel(self, server: str, options: _Options) -> typing.Any:
        """A grpc.Channel to `server`.

        Raises ValueError if the settings contradict each other, would give the token away, or name files that hold no
        PEM, and OSError for those that cannot be read.
        """
        return self._opener(grpc, server, options)()

    def aio_opener(self, server: str, options: _Options) -> typing.Callable[[], typing.Any]:
        """Opens a grpc.aio.Channel, which belongs to the event loop that runs then. Raises the same, but at once."""
        return self._opener(grpc.aio, server, options)

    def metadata(self) -> list[tuple[str, str]]:
        """What each call carries."""
        return [("authorization", f"Bearer {self.token}")] if self.token else []

    def _opener(self, library: typing.Any, server: str, options: _Options) -> typing.Callable[[], typing.Any]:
        if self.token and not re.fullmatch(f"[!-~]{{1,{_MOST_TOKEN_BYTES}}}", self.token):
            raise ValueError(f"token must be printable ASCII without blanks, at most {_MOST_TOKEN_BYTES} bytes")
        if (self.cert_file is None) != (self.key_file is None):
            raise ValueError("cert_file and key_file are of use together only")
        if self.tls or self.ca_file is not None or self.cert_file is not None:
            files = (self.ca_file, self.key_file, self.cert_file)
            pems = [None if file is None else pathlib.Path(file).read_bytes() for file in files]
            self._check_files(pems[0], pems[2])
            credentials = grpc.ssl_channel_credentials(*pems)
            if self.server_name is not None:
                options = [*options, ("grpc.ssl_target_name_override", self.server_name)]
            return functools.partial(library.secure_channel, server, credentials, options)
        if self.server_name is not None:
            raise ValueError("server_name is of use with TLS only")
        if self.token and not self.send_token_in_plain_text and not is_local(server):
            raise ValueError(f"the token would go to {server} in plain text, where others can read it: use TLS")
        return functools.partial(library.insecure_channel, server, options)

    def _check_files(self, authorities: bytes | None, certificates: bytes | None) -> None:
        """gRPC would say of wrong files that no server can be reached."""
        if authorities is not None and not any(map(_is_certificate, _CERTIFICATE.findall(authorities))):
            raise ValueError(f"ca_file: no certificate can be read from {self.ca_file}; expected PEM")
        chain = _CERTIFICATE.findall(certificates or b"")
        # What is no regular file can be read but once. Of a chain gRPC leaves out what it cannot read.
        if certificates is None or (chain and not all(map(_is_certificate, chain))):
            return
        if not all(os.path.isfile(file) for file in (self.cert_file, self.key_file) if file is not None):
            return
        try:
            # An empty password: OpenSSL would ask the terminal for one.
            _context().load_cert_chain(typing.cast(str, self.cert_file), self.key_file, password="")
        except ssl.SSLError as error:
            reason = (error.reason or "no PEM").lower().replace("_", " ")
            raise ValueError(
                f"cert_file and key_file: {self.cert_file} and {self.key_file} do not hold a certificate and its "
                f"private key ({reason}); expected PEM, the key without a password"
            ) from None


def require_security(value: object) -> None:
    """Raises TypeError for what is given as security and is none, such as a dict."""
    if not isinstance(value, Security):
        raise TypeError(f"security is of type {type(value).__name__}; it must be a curvd_client.Security")


def _context() -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.set_ciphers("DEFAULT:@SECLEVEL=0")  # the handshake judges how strong they are
    return context


def _is_certificate(pem: bytes) -> bool:
    plain = re.sub(rb"(BEGIN|END) \w+ CERTIFICATE", rb"\1 CERTIFICATE", pem)
    try:
        der = ssl.PEM_cert_to_DER_cert(plain.decode("ascii"))
        _context().load_verify_locations(cadata=der[: _size_of_first(der)])
    except (IndexError, ssl.SSLError, ValueError):
        return False
    return True


def _size_of_first(der: bytes) -> int:
    """Of the certificate alone: what OpenSSL calls a trusted one has more behind it. X.690, 8.1.3: the length's length comes first."""
    if der[1] < 0x80:
        return 2 + der[1]
    end = 2 + (der[1] & 0x7F)
    return end + int.from_bytes(der[2:end], "big")
