// The Node.js client against a real curvd (CURVD_SERVER) and against servers that misbehave.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { test } from "node:test";
import { DEFAULT_QUANTITIES, PointStatus, estimateCurvature, estimateNormals } from "../../client/node/index.mjs";
import { failure, scripted, sphere } from "./node_helpers.mjs";

const grpc = createRequire(new URL("../../client/node/", import.meta.url))("@grpc/grpc-js");
const server = process.env.CURVD_SERVER;

function assertSphere(estimate, radius) {
  // 20,000 points: the error of the estimate itself is far below a percent.
  assert.ok(estimate.meanCurvature.every((mean) => Math.abs(mean * radius - 1) < 0.02));
  assert.ok(estimate.gaussianCurvature.every((gaussian) => Math.abs(gaussian * radius ** 2 - 1) < 0.04));
  assert.ok(estimate.k1.every((k1, i) => k1 <= estimate.k2[i]));
  assert.ok(estimate.status.every((status) => status === PointStatus.OK));
}

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

test("only what was asked for comes", async () => {
  const cloud = sphere(40_000, 2);
  const everything = await estimateCurvature(...cloud, { server });
  const some = await estimateCurvature(...cloud, { server, quantities: ["principalDirections", "meanCurvature"] });
  assert.deepEqual(Object.keys(some).sort(), ["d1", "d2", "meanCurvature", "status", "summary"]);
  for (const name of ["d1", "d2", "meanCurvature", "status"]) assert.deepEqual(some[name], everything[name]);
});

test("unknown quantities are refused before a call", async () => {
  for (const quantities of [["curl"], ["radius", "radius"], ["unspecified"]]) {
    await assert.rejects(estimateCurvature(...sphere(10, 1), { server, quantities }), TypeError);
  }
  for (const quantities of ["radius", null, 5, { 0: "radius" }]) {
    const message = `quantities is ${JSON.stringify(quantities)}; it must be an array`;
    await assert.rejects(estimateCurvature(...sphere(10, 1), { server, quantities }), (error) => {
      assert.ok(error instanceof TypeError && error.message.startsWith(message), error.message);
      return true;
    });
  }
});

test("no quantities are all quantities", async () => {
  const { summary, ...all } = await estimateCurvature(...sphere(100, 1), { server });
  const { summary: other, ...none } = await estimateCurvature(...sphere(100, 1), { server, quantities: [] });
  assert.deepEqual(none, all);
  assert.equal(other.pointCount, summary.pointCount);
});

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

const isNear = (array, expected, tolerance) => array.every((scalar, i) => Math.abs(scalar - expected[i]) < tolerance);

test("a cloud without normals gets them", async () => {
  const [positions, normals] = sphere(20_000, 2);
  const estimate = await estimateCurvature(positions, null, { server });
  assertSphere(estimate, 2);
  assert.ok(isNear(estimate.normal, normals, 0.01));
  assert.equal(estimate.normalResidual, undefined);
  assert.equal(estimate.summary.normals.closedPieceCount, 1);
  await assert.rejects(estimateCurvature(positions, undefined, { server }), /give null/);
});

test("given normals are turned only if a side is asked for", async () => {
  const [positions, normals] = sphere(2_000, 2);
  const inward = normals.map((scalar) => -scalar);
  const given = await estimateCurvature(positions, inward, { server });
  assert.ok(given.meanCurvature[0] < 0);
  assert.equal(given.normal, undefined);
  const turned = await estimateCurvature(positions, inward, { server, orientation: "closed" });
  assert.ok(turned.meanCurvature[0] > 0);
  assert.ok(isNear(turned.normal, normals, 1e-6));
  assert.equal(turned.summary.normals.turnedCount, 2_000);
});

test("normals alone have quality and no curvature", async () => {
  const [positions, normals] = sphere(2_000, 2, Float64Array, 5e6);
  const made = await estimateNormals(positions, null, { server, method: "pca", neighborCount: 12 });
  assert.deepEqual(Object.keys(made).sort(), ["normal", "normalResidual", "normalVarianceRatio", "status", "summary"]);
  assert.ok(isNear(made.normal, normals, 0.05));
  assert.equal(made.summary.normals.method, "NORMAL_METHOD_PCA");
  assert.equal(made.summary.seconds.estimate, 0);
  const none = await estimateNormals(new Float32Array(), null, { server });
  assert.equal(none.normal.length, 0);
});

test("sides follow viewpoints and directions", async () => {
  const [positions, normals] = sphere(2_000, 2);
  const ask = (options) => estimateNormals(positions, null, { server, neighborCount: 12, ...options });
  assert.ok(isNear((await ask({ viewpoint: [0, 0, 0] })).normal, normals.map((scalar) => -scalar), 0.1));
  assert.ok(isNear((await ask({ viewpoints: positions.map((scalar) => 3 * scalar) })).normal, normals, 0.1));
  const { normal } = await ask({ direction: [0, 0, -1] });
  assert.ok(normal.every((scalar, i) => i % 3 !== 2 || scalar <= 0));
});

test("options of normals that make no sense are refused before a call", async () => {
  const [positions, normals] = sphere(10, 1);
  for (const [message, given, options] of [
    [/exclude/, null, { orientation: "closed", direction: [0, 0, 1] }],
    [/orientation is "up"/, null, { orientation: "up" }],
    [/viewpoint is \[1,2\]/, null, { viewpoint: [1, 2] }],
    [/viewpoints must be/, null, { viewpoints: [1, 2] }],
    [/and viewpoints 3/, null, { viewpoints: new Float32Array(3) }],
    [/goes with normals = null/, normals, { method: "pca" }],
    [/method of normals is "best"/, null, { method: "best" }],
    [/exclude/, null, { neighborCount: 10, radius: 1 }],
  ]) {
    await assert.rejects(estimateNormals(positions, given, { server, ...options }), (error) => {
      assert.ok(error instanceof TypeError);
      assert.match(error.message, message);
      return true;
    });
  }
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

test("a sphere has the curvature of a sphere", async () => {
  const estimate = await estimateCurvature(...sphere(20_000, 2), { server });
  assert.equal(estimate.summary.statusCounts.ok, 20_000);
  assert.equal(estimate.d1.length, 60_000);
  assertSphere(estimate, 2);
});

test("doubles stay exact far from the origin", async () => {
  assertSphere(await estimateCurvature(...sphere(20_000, 2, Float64Array, 5e6), { server }), 2);
});

test("many chunks arrive in order", async () => {
  const [positions, normals] = sphere(200_000, 3);
  const estimate = await estimateCurvature(positions, normals, { server });
  assertSphere(estimate, 3);
});

test("options reach the server", async () => {
  const estimate = await estimateCurvature(...sphere(2_000, 1), { server, radius: 0.25, estimator: "hexagram" });
  assert.ok(estimate.radius.every((radius) => radius === 0.25));
});

test("every estimator has a name", async () => {
  const cloud = sphere(20_000, 2);
  for (const estimator of ["avg-hexagram", "hexagram", "delaunay", "jet", "aso", "normal-regression"]) {
    assertSphere(await estimateCurvature(...cloud, { server, estimator }), 2);
  }
  for (const estimator of ["uniform", "independent"]) {
    const { summary } = await estimateCurvature(...cloud, { server, estimator });
    assert.equal(summary.statusCounts.ok, 20_000);
  }
});

test("a jet needs as many neighbors as coefficients", async () => {
  const jet = { server, estimator: "jet", neighborCount: 14 };
  const estimate = await estimateCurvature(...sphere(1_000, 2), { ...jet, jetDegree: 4 });
  assert.ok(estimate.status.every((status) => status === PointStatus.SINGULAR_FIT));
  assert.equal(estimate.summary.statusCounts.singularFit, 1_000);
  const conics = await estimateCurvature(...sphere(1_000, 2), { ...jet, jetDegree: 2 });
  assert.equal(conics.summary.statusCounts.ok, 1_000);
});

test("auto chooses what suits the cloud", async () => {
  const [positions, normals] = sphere(10_000, 2);
  // Noise of a fixed sequence (Park, Miller 1988), evenly spread.
  let state = 1;
  const random = () => (state = (state * 48_271) % 2_147_483_647) / 2_147_483_647;
  const noisy = positions.map((scalar) => scalar + 0.06 * (random() - 0.5));
  const meanError = ({ meanCurvature }) => meanCurvature.reduce((sum, mean) => sum + Math.abs(mean - 0.5), 0) / 10_000;
  const auto = await estimateCurvature(noisy, normals, { server, estimator: "auto" });
  const fixed = await estimateCurvature(noisy, normals, { server });
  assert.equal(auto.summary.statusCounts.ok, 10_000);
  assert.ok(meanError(auto) < meanError(fixed), `${meanError(auto)} and ${meanError(fixed)}`);
  const { outcomes, positionNoise } = auto.summary.scale;
  assert.ok(Math.abs(outcomes.reduce((sum, { share }) => sum + share, 0) - 1) < 1e-6);
  assert.ok(outcomes.some(({ estimator }) => estimator === "ESTIMATOR_JET_FITTING"));
  assert.ok(positionNoise > 0);
  assert.ok(!fixed.summary.scale);
});

test("values come with how sure they are", async () => {
  const asked = ["standardErrors", "chosenNeighborCount", "estimatorWeights"];
  const quantities = [...DEFAULT_QUANTITIES, ...asked];
  const estimate = await estimateCurvature(...sphere(5_000, 2), { server, estimator: "auto", quantities });
  const { meanCurvatureStandardError, k1StandardError, k2StandardError, chosenNeighborCount } = estimate;
  for (const errors of [meanCurvatureStandardError, k1StandardError, k2StandardError]) {
    assert.equal(errors.length, 5_000);
    assert.ok(errors.every((error) => error > 0));
  }
  assert.ok(chosenNeighborCount.every((count) => count >= 16 && count <= 2048));
  const { avgHexagramWeight, normalRegressionWeight, jetWeight } = estimate;
  assert.ok(jetWeight.every((weight, i) => Math.abs(weight + avgHexagramWeight[i] + normalRegressionWeight[i] - 1) < 1e-5));
  assert.ok(estimate.d1.length === 15_000 && estimate.summary.scale.normalNoise >= 0);
});

test("normal curvature takes one direction or one for each point", async () => {
  const cloud = sphere(2_000, 2);
  const asked = { server, quantities: ["normalCurvature"] };
  const one = await estimateCurvature(...cloud, { ...asked, curvatureDirection: [0, 0, 1] });
  assert.ok(Math.abs(one.normalCurvature[1_000] - 0.5) < 0.02);
  const curvatureDirections = new Float32Array(6_000).fill(1, 0, 3_003);
  const each = await estimateCurvature(...cloud, { ...asked, curvatureDirections });
  assert.ok(Math.abs(each.normalCurvature[1_000] - 0.5) < 0.02);
  assert.ok(Number.isNaN(each.normalCurvature[1_001]));
  await assert.rejects(estimateCurvature(...cloud, asked), /needs curvatureDirection or curvatureDirections/);
  await assert.rejects(estimateCurvature(...cloud, { server, curvatureDirection: [0, 0, 1] }), /need "normalCurvature"/);
});

test("estimator or scale alone may be left open", async () => {
  const cloud = sphere(5_000, 2);
  const jets = { server, estimator: "jet", neighborCount: "auto", neighborCountRange: [64, 128] };
  const { summary } = await estimateCurvature(...cloud, jets);
  const told = summary.scale.outcomes.map(({ estimator, neighborCount }) => [estimator, neighborCount]);
  assert.deepEqual(told, [64, 91, 128].map((count) => ["ESTIMATOR_JET_FITTING", count]));
  const counted = await estimateCurvature(...cloud, { server, estimator: "auto", neighborCount: 100 });
  assert.ok(counted.summary.scale.outcomes.every(({ neighborCount }) => neighborCount === 100));
  const near = await estimateCurvature(...cloud, { server, estimator: "auto", maxRadius: 0.3, scalePerCloud: true });
  assert.ok(near.radius.every((radius, i) => near.status[i] !== PointStatus.OK || radius <= 0.3));
  assert.ok(near.summary.statusCounts.ok > 4_000);
});

test("scales that the server refuses are named", async () => {
  const cloud = sphere(100, 1);
  for (const [words, options] of [
    [/it must be auto, avg-hexagram/, { estimator: "aso", neighborCount: "auto" }],
    [/jet_degree is 2; it must be 4/, { estimator: "jet", neighborCount: "auto", jetDegree: 2 }],
    [/least_neighbor_count is 15; it must be from 16/, { estimator: "auto", neighborCountRange: [15, 64] }],
    [/max_radius is nan/, { estimator: "auto", maxRadius: NaN }],
  ]) {
    const error = await failure(estimateCurvature(...cloud, { server, ...options }));
    assert.equal(error.reason, "INVALID_OPTION");
    assert.match(error.message, words);
  }
});

test("scales that make no sense are refused before a call", async () => {
  const cloud = [new Float32Array(3), new Float32Array(3)];
  const auto = { estimator: "auto" };
  for (const [message, options] of [
    [/need neighborCount/, { neighborCountRange: [16, 64] }],
    [/need neighborCount/, { maxRadius: 1 }],
    [/need neighborCount/, { scalePerCloud: true }],
    [/need neighborCount/, { ...auto, neighborCount: 50, maxRadius: 1 }],
    [/neighborCount is "some"/, { neighborCount: "some" }],
    [/radius does not go with "auto"/, { ...auto, radius: 1 }],
    [/radius does not go with "auto"/, { neighborCount: "auto", radius: 1 }],
    [/neighborCountRange is 64/, { ...auto, neighborCountRange: 64 }],
    [/neighborCountRange is \[64\]/, { ...auto, neighborCountRange: [64] }],
    [/neighborCountRange is \["16",64\]/, { ...auto, neighborCountRange: ["16", 64] }],
  ]) {
    await assert.rejects(estimateCurvature(...cloud, { server: "127.0.0.1:1", ...options }), (error) => {
      assert.ok(error instanceof TypeError, String(error));
      assert.match(error.message, message);
      return true;
    });
  }
});

test("even weights reach the server", async () => {
  const [positions, normals] = sphere(1_000, 2);
  // An ellipsoid: on a sphere all triangles say the same.
  const stretched = positions.map((scalar, i) => (i % 3 === 2 ? 2 * scalar : scalar));
  const delaunay = { server, estimator: "delaunay" };
  const fading = await estimateCurvature(stretched, normals, delaunay);
  const even = await estimateCurvature(stretched, normals, { ...delaunay, evenWeights: true });
  assert.notDeepEqual(fading.meanCurvature, even.meanCurvature);
});

test("opposed normals are warned of or refused", async () => {
  const [positions, normals] = sphere(2_000, 2);
  for (let i = 0; i < normals.length / 2; i++) normals[i] *= -1;
  const warned = new Promise((resolve) => process.once("warning", resolve));
  const { status, summary } = await estimateCurvature(positions, normals, { server });
  const warning = await warned;
  assert.equal(warning.name, "CurvdWarning");
  assert.equal(warning.code, "CURVD_OPPOSED_NORMALS");
  assert.match(warning.message, /make all normals point to one side/);
  const opposed = status.filter((each) => each === PointStatus.OPPOSED_NORMALS).length;
  assert.ok(opposed > 0);
  assert.equal(summary.warnings[0].pointCount, opposed);
  assert.equal(summary.warnings[0].flippedPatchCount, 1);
  const error = await failure(estimateCurvature(positions, normals, { server, rejectOpposedNormals: true }));
  assert.equal(error.reason, "OPPOSED_NORMALS");
});

test("priorities do not change a byte", async () => {
  const cloud = sphere(1_000, 1);
  const { k1 } = await estimateCurvature(...cloud, { server });
  for (const priority of ["interactive", "batch"]) {
    assert.deepEqual((await estimateCurvature(...cloud, { server, priority })).k1, k1);
  }
});

test("an empty cloud gives an empty result", async () => {
  const estimate = await estimateCurvature(new Float32Array(), new Float32Array(), { server });
  assert.equal(estimate.status.length, 0);
  assert.equal(estimate.summary.pointCount, 0);
  assert.deepEqual(estimate.d2, new Float32Array());
  const some = await estimateCurvature(new Float32Array(), new Float32Array(), { server, quantities: ["radius"] });
  assert.deepEqual(Object.keys(some).sort(), ["radius", "status", "summary"]);
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
