// What the Node.js client asks for comes, and is right. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { test } from "node:test";
import { PointStatus, estimateCurvature } from "../../client/node/index.mjs";
import { enumValues } from "../../client/node/protocol.mjs";
import { assertSphere, sphere } from "./node_helpers.mjs";

const server = process.env.CURVD_SERVER;

test("only what was asked for comes", async () => {
  const cloud = sphere(40_000, 2);
  const everything = await estimateCurvature(...cloud, { server });
  const some = await estimateCurvature(...cloud, { server, quantities: ["principalDirections", "meanCurvature"] });
  assert.deepEqual(Object.keys(some).sort(), ["d1", "d2", "meanCurvature", "status", "summary"]);
  for (const name of ["d1", "d2", "meanCurvature", "status"]) assert.deepEqual(some[name], everything[name]);
});

test("the statuses are those of the contract", () => {
  const [, ...names] = enumValues("curvature.v1.PointStatus");
  assert.deepEqual(Object.keys(PointStatus).map((name) => `POINT_STATUS_${name}`), names);
  assert.deepEqual(Object.values(PointStatus), names.map((_, i) => i + 1));
});

test("unknown quantities are refused before a call", async () => {
  for (const quantities of [["curl"], ["radius", "radius"], ["unspecified"]]) {
    await assert.rejects(estimateCurvature(...sphere(10, 1), { server, quantities }), TypeError);
  }
  const ofArray = estimateCurvature(...sphere(10, 1), { server, quantities: ["radius", "d1"] });
  await assert.rejects(ofArray, /^TypeError: quantities has "d1", which comes with "principalDirections": ask for that$/);
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

test("even weights reach the server", async () => {
  const [positions, normals] = sphere(1_000, 2);
  // An ellipsoid: on a sphere all triangles say the same.
  const stretched = positions.map((scalar, i) => (i % 3 === 2 ? 2 * scalar : scalar));
  const delaunay = { server, estimator: "delaunay" };
  const fading = await estimateCurvature(stretched, normals, delaunay);
  const even = await estimateCurvature(stretched, normals, { ...delaunay, evenWeights: true });
  assert.notDeepEqual(fading.meanCurvature, even.meanCurvature);
});

test("projecting reaches the server", async () => {
  const [positions, normals] = sphere(1_000, 2);
  const shaken = positions.map((scalar, i) => (Math.floor(i / 3) % 50 === 0 ? 1.02 * scalar : scalar));
  const aso = { server, estimator: "aso", neighborCount: 200 };
  const levels = await estimateCurvature(shaken, normals, aso);
  const surface = await estimateCurvature(shaken, normals, { ...aso, project: true });
  const spread = (values) => Math.max(...values) - Math.min(...values);
  assert.ok(spread(surface.meanCurvature) < spread(levels.meanCurvature));
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
