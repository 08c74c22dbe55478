// Estimator and scale that the Node.js client leaves to the server. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_QUANTITIES, PointStatus, estimateCurvature } from "../../client/node/index.mjs";
import { failure, sphere } from "./node_helpers.mjs";

const server = process.env.CURVD_SERVER;

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
  const { avgHexagramWeight, normalRegressionWeight, jetWeight, asoWeight } = estimate;
  const sumAt = (i) => avgHexagramWeight[i] + normalRegressionWeight[i] + jetWeight[i] + asoWeight[i];
  assert.ok(asoWeight.every((_, i) => Math.abs(sumAt(i) - 1) < 1e-5));
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
    [/it must be auto, avg-hexagram/, { estimator: "hexagram", neighborCount: "auto" }],
    [/jet_degree is 2; it must be 4/, { estimator: "jet", neighborCount: "auto", jetDegree: 2 }],
    [/least_neighbor_count is 15; it must be from 16/, { estimator: "auto", neighborCountRange: [15, 64] }],
    [/max_radius is inf/, { estimator: "auto", maxRadius: Infinity }],
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
    [/neighborCountRange is \[0,64\]/, { ...auto, neighborCountRange: [0, 64] }],
    [/neighborCountRange is Uint8Array\(2\) \[0,64\]/, { ...auto, neighborCountRange: Uint8Array.of(0, 64) }],
    [/maxRadius is 0; it must be a number above 0/, { ...auto, maxRadius: 0 }],
    [/maxRadius is NaN; it must be a number above 0/, { ...auto, maxRadius: NaN }],
    [/neighborCountRange is \["16",64\]/, { ...auto, neighborCountRange: ["16", 64] }],
  ]) {
    await assert.rejects(estimateCurvature(...cloud, { server: "127.0.0.1:1", ...options }), (error) => {
      assert.ok(error instanceof TypeError, String(error));
      assert.match(error.message, message);
      return true;
    });
  }
});
