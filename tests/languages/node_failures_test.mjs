// How calls of the Node.js client fail, against a real curvd (CURVD_SERVER) and servers that misbehave.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { test } from "node:test";
import { PointStatus, estimateCurvature, estimateNormals } from "../../client/node/index.mjs";
import { failure, scripted, sphere } from "./node_helpers.mjs";

const grpc = createRequire(new URL("../../client/node/", import.meta.url))("@grpc/grpc-js");
const server = process.env.CURVD_SERVER;

test("what was asked for and does not come is a breach of the protocol", async () => {
  const floats = (scalars) => Buffer.alloc(4 * scalars);
  const script = (call) => {
    const status = Buffer.alloc(10, 1);
    call.write({ result: { firstIndex: 0, pointCount: 10, status, k1: floats(10), radius: floats(10) } });
    call.write({ summary: { pointCount: 10 } });
    call.end();
  };
  const ask = (quantities) =>
    scripted(script, (fake) => estimateCurvature(...sphere(10, 1), { server: fake, quantities, maxAttempts: 1 }));
  const error = await failure(ask(["radius", "principalCurvatures"]));
  assert.equal(error.codeName, "INTERNAL");
  assert.match(error.message, /without k2, which the call asked for/);
  // What came unasked is left out.
  assert.deepEqual(Object.keys(await ask(["radius"])).sort(), ["radius", "status", "summary"]);
  assert.deepEqual(Object.keys(await ask([])).sort(), ["k1", "radius", "status", "summary"]);
});

test("an invalid point is named in the error, or skipped on request", async () => {
  const [positions, normals] = sphere(1_000, 1);
  positions[3 * 123] = NaN;
  const error = await failure(estimateCurvature(positions, normals, { server }));
  assert.equal(error.codeName, "INVALID_ARGUMENT");
  assert.match(error.details, /123/);
  assert.notEqual(error.reason, "");
  // What leads to the line in the server's log is in the message itself.
  assert.ok(error.message.includes(`(request ${error.metadata.request_id})`), error.message);
  const estimate = await estimateCurvature(positions, normals, { server, skipInvalid: true });
  assert.equal(estimate.status[123], PointStatus.INVALID_INPUT);
  assert.equal(estimate.summary.statusCounts.invalidInput, 1);
});

test("a deadline ends the call", async () => {
  const error = await failure(estimateCurvature(...sphere(200_000, 1), { server, timeoutMs: 1 }));
  assert.equal(error.codeName, "DEADLINE_EXCEEDED");
});

test("arguments that make no request are refused", async () => {
  const floats = (count) => new Float32Array(count);
  await assert.rejects(estimateCurvature([0, 0, 0], [0, 0, 1]), TypeError);
  await assert.rejects(estimateCurvature(floats(3), new Float64Array(3)), TypeError);
  await assert.rejects(estimateCurvature(floats(4), floats(4)), TypeError);
  await assert.rejects(estimateCurvature(floats(3), floats(6)), TypeError);
  await assert.rejects(estimateCurvature(floats(3), floats(3), { estimator: "best" }), TypeError);
  await assert.rejects(estimateCurvature(floats(3), floats(3), { priority: "now" }), TypeError);
  await assert.rejects(estimateCurvature(floats(3), floats(3), { neighborCount: 9, radius: 1 }), TypeError);
});

test("arrays that are none are named, and what they are", async () => {
  const positions = new Float32Array(3);
  for (const [call, message] of [
    [estimateCurvature([0, 0, 0], null), "positions is an Array; it must be a Float32Array or a Float64Array"],
    [estimateCurvature(null, null), "positions is null; it must be a Float32Array or a Float64Array"],
    [
      estimateNormals(positions, { neighborCount: 9 }),
      "normals is an object; it must be a Float32Array, as positions is, or null to have normals estimated; options are the third argument",
    ],
    [
      estimateCurvature(positions, new Float64Array(3)),
      "normals is a Float64Array; it must be a Float32Array, as positions is, or null to have normals estimated",
    ],
  ]) {
    await assert.rejects(call, { name: "TypeError", message });
  }
});

test("nobody listening is unavailable", async () => {
  const error = await failure(estimateCurvature(...sphere(10, 1), { server: "127.0.0.1:1", maxAttempts: 2 }));
  assert.equal(error.codeName, "UNAVAILABLE");
});

test("breaches of the protocol are found", async () => {
  const result = (firstIndex, pointCount, statusBytes = pointCount) => ({
    result: { firstIndex, pointCount, status: Buffer.alloc(statusBytes, 1) },
  });
  const summary = (pointCount) => ({ summary: { pointCount } });
  const breaches = {
    "starts at 5, not 4": [result(0, 4), result(5, 5), summary(10)],
    "starts at 0, not 10": [result(0, 10), result(0, 10), summary(10)],
    "up to point 11": [result(0, 11), summary(11)],
    "9 results": [result(0, 9), summary(10)],
    "summary of 9": [result(0, 10), summary(9)],
    "without a summary": [result(0, 10)],
    "has 9 bytes, not 10": [result(0, 10, 9), summary(10)],
    "of 0 points": [result(0, 0), summary(10)],
  };
  for (const [message, responses] of Object.entries(breaches)) {
    const script = (call) => {
      responses.forEach((response) => call.write(response));
      call.end();
    };
    const error = await scripted(script, (fake) => failure(estimateCurvature(...sphere(10, 1), { server: fake })));
    assert.equal(error.codeName, "INTERNAL");
    assert.ok(error.message.includes(message), `${error.message} should say: ${message}`);
  }
});

test("a server that is too old to choose a scale is found", async () => {
  const old = (call) => {
    call.write({ accepted: { options: { neighborCount: 50 } } });
    call.write({ result: { firstIndex: 0, pointCount: 10, status: Buffer.alloc(10, 1) } });
    call.write({ summary: { pointCount: 10 } });
    call.end();
  };
  const ask = (fake) => estimateCurvature(...sphere(10, 1), { server: fake, neighborCount: "auto", maxAttempts: 1 });
  const error = await scripted(old, (fake) => failure(ask(fake)));
  assert.equal(error.codeName, "UNIMPLEMENTED");
  assert.match(error.message, /too old to choose a scale/);
});

test("a server that dies is tried again, and a defect is not", async () => {
  for (const code of [grpc.status.UNAVAILABLE, grpc.status.UNKNOWN, grpc.status.INTERNAL]) {
    let calls = 0;
    const dieOnce = (call) => {
      calls += 1;
      if (calls === 1) return call.emit("error", { code, details: "Stream removed" });
      call.write({ summary: { pointCount: 0 } });
      call.end();
    };
    const none = new Float32Array();
    const estimate = await scripted(dieOnce, (fake) => estimateCurvature(none, none, { server: fake }));
    assert.deepEqual([estimate.summary.pointCount, calls], [0, 2]);
  }
  let calls = 0;
  const breach = (call) => {
    calls += 1;
    call.end();
  };
  const error = await scripted(breach, (fake) => failure(estimateCurvature(...sphere(10, 1), { server: fake })));
  assert.deepEqual([error.codeName, error.transient, calls], ["INTERNAL", false, 1]);
});

test("another replica is tried", async () => {
  for (let i = 0; i < 4; ++i) {
    const replicas = `127.0.0.1:1,${server}`;
    const estimate = await estimateCurvature(...sphere(100, 1), { server: replicas, maxAttempts: 2 });
    assert.equal(estimate.summary.pointCount, 100);
  }
});

test("error details reach the caller", async () => {
  // google.rpc.Status with ErrorInfo{MEMORY_LIMIT, curvd, limit: 8} and RetryInfo{1.5 s}, in wire format.
  const field = (number, bytes) => Buffer.concat([Buffer.from([(number << 3) | 2, bytes.length]), Buffer.from(bytes)]);
  const any = (name, value) =>
    field(3, Buffer.concat([field(1, Buffer.from(`type.googleapis.com/google.rpc.${name}`)), field(2, value)]));
  const text = (number, string) => field(number, Buffer.from(string));
  const info = Buffer.concat([
    text(1, "MEMORY_LIMIT"),
    text(2, "curvd"),
    field(3, Buffer.concat([text(1, "limit"), text(2, "8")])),
  ]);
  const retry = field(1, Buffer.from([0x08, 1, 0x10, 0x80, 0xca, 0xb5, 0xee, 0x01]));
  const packed = Buffer.concat([any("ErrorInfo", info), any("RetryInfo", retry), any("Unknown", Buffer.from("?"))]);
  const refuse = async (details) => {
    const script = (call) => {
      const metadata = new grpc.Metadata();
      metadata.set("grpc-status-details-bin", details);
      call.emit("error", { code: grpc.status.RESOURCE_EXHAUSTED, details: "memory: 9 bytes, limit 8", metadata });
    };
    const once = (fake) => estimateCurvature(...sphere(10, 1), { server: fake, maxAttempts: 1 });
    const error = await scripted(script, (fake) => failure(once(fake)));
    assert.equal(error.codeName, "RESOURCE_EXHAUSTED");
    assert.equal(error.details, "memory: 9 bytes, limit 8");
    return error;
  };
  const error = await refuse(packed);
  assert.equal(error.reason, "MEMORY_LIMIT");
  assert.deepEqual(error.metadata, { limit: "8" });
  assert.equal(error.retryAfter, 1.5);
  assert.equal((await refuse(Buffer.from("no message"))).reason, "");
});
