// Normals that the Node.js client has made or turned. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { test } from "node:test";
import { PointStatus, estimateCurvature, estimateNormals } from "../../client/node/index.mjs";
import { assertSphere, failure, sphere } from "./node_helpers.mjs";

const server = process.env.CURVD_SERVER;

const isNear = (array, expected, tolerance) => array.every((scalar, i) => Math.abs(scalar - expected[i]) < tolerance);

test("a cloud without normals gets them", async () => {
  const [positions, normals] = sphere(20_000, 2);
  const estimate = await estimateCurvature(positions, null, { server });
  assertSphere(estimate, 2);
  assert.ok(isNear(estimate.normal, normals, 0.01));
  assert.equal(estimate.normalResidual, undefined);
  assert.equal(estimate.summary.normals.closedPieceCount, 1);
  await assert.rejects(estimateCurvature(positions, undefined, { server }), /normals is undefined; .*or null to have normals estimated$/);
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
    [/viewpoint is \[0,0,NaN\]; it must be three finite numbers/, null, { viewpoint: [0, 0, NaN] }],
    [/viewpoint is Float32Array\(3\) \[0,Infinity,0\]; it must be/, null, { viewpoint: Float32Array.of(0, Infinity, 0) }],
    [/direction is \["0",0,1\]; it must be/, null, { direction: ["0", 0, 1] }],
    [/viewpoints is an Array; it must be a Float32Array, as positions is$/, null, { viewpoints: [1, 2] }],
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
