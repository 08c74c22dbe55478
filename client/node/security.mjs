// How a client knows its server, and shows who it is.
import { X509Certificate, createPrivateKey } from "node:crypto";
import { readFileSync } from "node:fs";
import grpc from "@grpc/grpc-js";
import { isLocal } from "./addresses.mjs";

const MOST_TOKEN_BYTES = 4096;

const readOrNull = (path) => (path === undefined ? null : readFileSync(path));

function isCertificate(pem) {
  try {
    return Boolean(new X509Certificate(pem));
  } catch {
    return false;
  }
}

// gRPC would say of wrong files that no server can be reached, or name none of them.
function checkPem({ caFile, certFile, keyFile }, authorities, key, certificate) {
  const one = /-----BEGIN (?:\w+ )?CERTIFICATE-----[^]*?-----END (?:\w+ )?CERTIFICATE-----/g;
  if (authorities !== null && !(authorities.toString("latin1").match(one) ?? []).some(isCertificate)) {
    throw new TypeError(`caFile: no certificate can be read from ${caFile}; expected PEM`);
  }
  if (certificate === null) return;
  if (!isCertificate(certificate)) {
    throw new TypeError(`certFile: no certificate can be read from ${certFile}; expected PEM`);
  }
  let privateKey;
  try {
    privateKey = createPrivateKey(key);
  } catch {
    throw new TypeError(`keyFile: no private key can be read from ${keyFile}; expected PEM without a password`);
  }
  if (!new X509Certificate(certificate).checkPrivateKey(privateKey)) {
    throw new TypeError(`keyFile: ${keyFile} holds the private key of another certificate than ${certFile}`);
  }
}

// Credentials and channel options for a server, from `security`:
//   tls                   encrypt, and check the server's certificate; implied by caFile and certFile
//   caFile                PEM file of the authorities that the server's certificate may be of. DEFAULT: Node's own
//   certFile, keyFile     PEM files of the certificate that the client shows, and of its private key
//   serverName            name to find in the server's certificate. DEFAULT: the host in the address
//   token                 bearer token, sent with each call: printable ASCII without blanks, at most 4096 bytes;
//                         "" is none
//   sendTokenInPlainText  whether the token may go to other machines without TLS. DEFAULT: false
// Throws a TypeError if the settings contradict each other, name files that hold no PEM, or would give the token away, and
// the error of node:fs for files that cannot be read.
export function connectionTo(server, security = {}) {
  const { tls = false, caFile, certFile, keyFile, serverName, token, sendTokenInPlainText = false } = security;
  if ((certFile === undefined) !== (keyFile === undefined)) {
    throw new TypeError("certFile and keyFile are of use together only");
  }
  if (tls || caFile !== undefined || certFile !== undefined) {
    const files = [caFile, keyFile, certFile].map(readOrNull);
    checkPem(security, ...files);
    return {
      credentials: grpc.credentials.createSsl(...files),
      options: serverName === undefined ? {} : { "grpc.ssl_target_name_override": serverName },
    };
  }
  if (serverName !== undefined) throw new TypeError("serverName is of use with TLS only");
  if (token && !sendTokenInPlainText && !isLocal(server)) {
    throw new TypeError(`the token would go to ${server} in plain text, where others can read it: use TLS`);
  }
  return { credentials: grpc.credentials.createInsecure(), options: {} };
}

// What each call carries. Throws a TypeError for a token that no header can hold, without showing it.
export function callMetadata({ token } = {}) {
  const metadata = new grpc.Metadata();
  if (!token) return metadata;
  if (!/^[!-~]+$/.test(token) || token.length > MOST_TOKEN_BYTES) {
    throw new TypeError(`the token must be printable ASCII without blanks, at most ${MOST_TOKEN_BYTES} bytes`);
  }
  metadata.set("authorization", `Bearer ${token}`);
  return metadata;
}
