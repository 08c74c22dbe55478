// How a client knows its server, and shows who it is.
import { readFileSync } from "node:fs";
import grpc from "@grpc/grpc-js";
import { isLocal } from "./addresses.mjs";

const readOrNull = (path) => (path === undefined ? null : readFileSync(path));

// Credentials and channel options for a server, from `security`:
//   tls                   encrypt, and check the server's certificate; implied by caFile and certFile
//   caFile                PEM file of the authorities that the server's certificate may be of. DEFAULT: Node's own
//   certFile, keyFile     PEM files of the certificate that the client shows, and of its private key
//   serverName            name to find in the server's certificate. DEFAULT: the host in the address
//   token                 bearer token, sent with each call
//   sendTokenInPlainText  whether the token may go to other machines without TLS. DEFAULT: false
// Throws a TypeError if the settings contradict each other or would give the token away.
export function connectionTo(server, security = {}) {
  const { tls = false, caFile, certFile, keyFile, serverName, token, sendTokenInPlainText = false } = security;
  if ((certFile === undefined) !== (keyFile === undefined)) {
    throw new TypeError("certFile and keyFile are of use together only");
  }
  if (tls || caFile !== undefined || certFile !== undefined) {
    return {
      credentials: grpc.credentials.createSsl(readOrNull(caFile), readOrNull(keyFile), readOrNull(certFile)),
      options: serverName === undefined ? {} : { "grpc.ssl_target_name_override": serverName },
    };
  }
  if (serverName !== undefined) throw new TypeError("serverName is of use with TLS only");
  if (token !== undefined && !sendTokenInPlainText && !isLocal(server)) {
    throw new TypeError(`the token would go to ${server} in plain text, where others can read it: use TLS`);
  }
  return { credentials: grpc.credentials.createInsecure(), options: {} };
}

// What each call carries.
export function callMetadata({ token } = {}) {
  const metadata = new grpc.Metadata();
  if (token !== undefined) metadata.set("authorization", `Bearer ${token}`);
  return metadata;
}
