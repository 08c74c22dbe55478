// Several neighbor counts in one call. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { test } from "node:test";
import { CurvatureClient, PointStatus, estimateCurvature } from "../../client/node/index.mjs";
import { failure, sphere } from "./node_helpers.mjs";

const server = process.env.CURVD_SERVER;
const neighborCounts = [16, 60, 200];

test("each count has the bytes of a call of its own", async () => {
  const cloud = sphere(20_000, 2);
  const { scales, summary } = await estimateCurvature(...cloud, { server, neighborCounts });
  assert.deepEqual(scales.map(({ neighborCount }) => neighborCount), neighborCounts);
  assert.equal(summary.statusCounts.ok, 60_000);
  for (const { neighborCount, ...arrays } of scales) {
    const { summary: _, ...alone } = await estimateCurvature(...cloud, { server, neighborCount });
    assert.deepEqual(arrays, alone);
  }
});

test("counts may be a typed array", async () => {
  for (const counts of [Uint32Array.of(16, 60), Float64Array.of(16, 60)]) {
    const { scales } = await estimateCurvature(...sphere(1_000, 2), { server, neighborCounts: counts });
    assert.deepEqual(scales.map(({ neighborCount }) => neighborCount), [16, 60]);
  }
});

test("chunks come count after count", async () => {
  const client = new CurvatureClient(server);
  const seen = [];
  const chunks = client.estimateChunks(...sphere(20_000, 2), { neighborCounts });
  for await (const { neighborCount, firstIndex, pointCount } of chunks) seen.push([neighborCount, firstIndex + pointCount]);
  client.close();
  assert.deepEqual(seen, neighborCounts.flatMap((count) => [[count, 16_384], [count, 20_000]]));
  assert.equal(chunks.summary.statusCounts.ok, 60_000);
});

test("a cloud may be too small for the larger counts alone", async () => {
  const { scales } = await estimateCurvature(...sphere(100, 1), { server, neighborCounts });
  assert.ok(scales[0].status.every((status) => status === PointStatus.OK));
  assert.ok(scales[2].status.every((status) => status === PointStatus.TOO_FEW_NEIGHBORS));
});

test("counts that make no request, and those that the server refuses, are named", async () => {
  const cloud = sphere(100, 1);
  const call = (options) => estimateCurvature(...cloud, { server, ...options });
  await assert.rejects(call({ neighborCounts: [32, 16] }), /must be an array of numbers that ascend/);
  for (const none of [[], 16, "16", null, new Set([16]), Uint32Array.of(32, 16), BigUint64Array.of(16n), [, 16]]) {
    await assert.rejects(call({ neighborCounts: none }), /neighborCounts is .*; it must be an array of numbers that ascend/);
  }
  await assert.rejects(call({ neighborCounts, radius: 1 }), /exclude neighborCount, radius/);
  const refused = await failure(call({ neighborCounts, estimator: "aso" }));
  assert.equal(refused.reason, "INVALID_OPTION");
  assert.match(refused.details, /estimator is aso; it must be one of avg-hexagram, normal-regression/);
});
