// The Node.js client and a curvd that asks who calls (CURVD_SECURE_SERVER).
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { CurvatureClient, estimateCurvature } from "../../client/node/index.mjs";
import { failure, sphere } from "./node_helpers.mjs";

const server = process.env.CURVD_SERVER;

// The settings for the curvd that asks for TLS, a certificate and a token.
const folder = process.env.CURVD_SECURE_DIR;
const security = {
  caFile: `${folder}/server.crt`,
  certFile: `${folder}/client.crt`,
  keyFile: `${folder}/client.key`,
  token: readFileSync(`${folder}/token`, "utf8"),
};
const secureEstimate = (changes) =>
  estimateCurvature(...sphere(1_000, 1), {
    server: process.env.CURVD_SECURE_SERVER,
    security: { ...security, ...changes },
    maxAttempts: 1,
  });

test("a server that asks who calls serves whom it knows", async () => {
  assert.equal((await secureEstimate({})).summary.statusCounts.ok, 1_000);
});

test("a server that asks who calls refuses others", async () => {
  assert.equal((await failure(secureEstimate({ token: "guess" }))).reason, "TOKEN_INVALID");
  assert.equal((await failure(secureEstimate({ token: undefined }))).reason, "TOKEN_MISSING");
  const unavailable = [
    { certFile: undefined, keyFile: undefined },
    { caFile: security.certFile },
    { serverName: "other.example" },
  ];
  for (const changes of unavailable) {
    assert.equal((await failure(secureEstimate(changes))).codeName, "UNAVAILABLE", JSON.stringify(changes));
  }
});

test("files that hold no PEM are named", async () => {
  for (const [changes, message] of [
    [{ caFile: `${folder}/token` }, /^caFile: no certificate can be read from .*token/],
    [{ certFile: `${folder}/token` }, /^certFile: no certificate can be read from .*token/],
    [{ keyFile: `${folder}/token` }, /^keyFile: no private key can be read from .*token/],
    [{ certFile: `${folder}/server.crt` }, /^keyFile: .*client.key holds the private key of another certificate/],
  ]) {
    await assert.rejects(secureEstimate(changes), { name: "TypeError", message });
  }
  await assert.rejects(secureEstimate({ caFile: `${folder}/nowhere` }), { code: "ENOENT" });
});

test("tokens that no header can hold are refused and not shown", async () => {
  for (const token of ["two words", "line\nbreak", "\u00e9", "x".repeat(5_000)]) {
    await assert.rejects(secureEstimate({ token }), (error) => {
      assert.match(error.message, /printable ASCII/);
      assert.ok(!error.message.includes(token));
      return error instanceof TypeError;
    });
  }
});

test("settings that do not exist, or are of another type, are refused and send nothing in plain text", async () => {
  const cloud = [new Float32Array(12), new Float32Array(12)];
  for (const [settings, message] of [
    [{ TLS: true }, "security has no option TLS: did you mean tls?"],
    [{ cafile: "x" }, "security has no option cafile: did you mean caFile?"],
    [{ tokn: "x" }, "security has no option tokn: did you mean token?"],
    [{ tls: "yes" }, 'tls is "yes"; it must be true or false'],
    [{ caFile: 5 }, "caFile is 5; it must be the path of a file"],
    [{ serverName: 5 }, "serverName is 5; it must be a string"],
    [{ sendTokenInPlainText: 1 }, "sendTokenInPlainText is 1; it must be true or false"],
    [{ token: 5 }, "token is a number; it must be a string"],
    ["secret", "security is a string; it must be an object, see connectionTo in security.mjs"],
    [new Map([["tls", true]]), "security is a Map; it must be an object, see connectionTo in security.mjs"],
  ]) {
    const refusal = { name: "TypeError", message };
    await assert.rejects(estimateCurvature(...cloud, { server, security: settings }), refusal);
    assert.throws(() => new CurvatureClient(server, { security: settings }), refusal);
  }
});

test("a token goes in plain text to this machine only", async () => {
  const cloud = [new Float32Array(12), new Float32Array(12)];
  for (const target of ["curvd.example:50061", "10.0.0.7:1", "127.0.0.1.example.com:1", "localhost:1,10.0.0.7:1"]) {
    const promise = estimateCurvature(...cloud, { server: target, security: { token: "secret" } });
    await assert.rejects(promise, { name: "TypeError", message: /plain text/ }, target);
  }
  for (const settings of [{ certFile: "a" }, { keyFile: "a" }, { serverName: "a" }]) {
    await assert.rejects(estimateCurvature(...cloud, { server, security: settings }), TypeError);
  }
});
