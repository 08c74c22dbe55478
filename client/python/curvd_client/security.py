"""How a client knows its server, and shows who it is."""

import dataclasses
import ipaddress
import pathlib
import typing

import grpc


@dataclasses.dataclass(frozen=True)
class Security:
    """What a connection needs where servers do not take calls of everybody in plain text.

    tls:                 encrypt, and check the server's certificate; implied by ca_file and cert_file.
    ca_file:             PEM file of the authorities that the server's certificate may be of. DEFAULT: gRPC's own.
    cert_file, key_file: PEM files of the certificate that the client shows, and of its private key.
    server_name:         name to find in the server's certificate. DEFAULT: the host in the address.
    token:               bearer token, sent with each call.
    send_token_in_plain_text: whether the token may go to other machines without TLS.
    """

    tls: bool = False
    ca_file: typing.Optional[str] = None
    cert_file: typing.Optional[str] = None
    key_file: typing.Optional[str] = None
    server_name: typing.Optional[str] = None
    token: typing.Optional[str] = dataclasses.field(default=None, repr=False)
    send_token_in_plain_text: bool = False

    def open_channel(self, server, options):
        """A grpc.Channel to `server`. ValueError if the settings contradict each other or would give the token away."""
        if (self.cert_file is None) != (self.key_file is None):
            raise ValueError("cert_file and key_file are of use together only")
        if self.tls or self.ca_file is not None or self.cert_file is not None:
            credentials = grpc.ssl_channel_credentials(*map(_bytes_of, (self.ca_file, self.key_file, self.cert_file)))
            if self.server_name is not None:
                options = [*options, ("grpc.ssl_target_name_override", self.server_name)]
            return grpc.secure_channel(server, credentials, options)
        if self.server_name is not None:
            raise ValueError("server_name is of use with TLS only")
        if self.token is not None and not self.send_token_in_plain_text and not _is_local(server):
            raise ValueError(f"the token would go to {server} in plain text, where others can read it: use TLS")
        return grpc.insecure_channel(server, options)

    def metadata(self):
        """What each call carries."""
        return [] if self.token is None else [("authorization", f"Bearer {self.token}")]


def _bytes_of(path):
    return None if path is None else pathlib.Path(path).read_bytes()


def _is_local(server):
    if server.startswith("unix:"):
        return True
    host = server.rpartition(":")[0].strip("[]")
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
