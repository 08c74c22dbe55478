// What the tests of the Node.js client share.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { CurvdError, PointStatus } from "../../client/node/index.mjs";
import { CurvatureService } from "../../client/node/protocol.mjs";

const grpc = createRequire(new URL("../../client/node/", import.meta.url))("@grpc/grpc-js");

// Positions and outward normals, evenly spread along a spiral.
export function sphere(pointCount, radius, ArrayType = Float32Array, offset = 0) {
  const positions = new ArrayType(3 * pointCount);
  const normals = new ArrayType(3 * pointCount);
  for (let i = 0; i < pointCount; i++) {
    const height = 1 - (2 * i + 1) / pointCount;
    const angle = Math.PI * (3 - Math.sqrt(5)) * i;
    const ring = Math.sqrt(1 - height * height);
    normals.set([ring * Math.cos(angle), ring * Math.sin(angle), height], 3 * i);
  }
  positions.set(normals.map((scalar) => radius * scalar + offset));
  return [positions, normals];
}

// Holds an estimate of a sphere to what is known of it.
export function assertSphere(estimate, radius) {
  // 20,000 points: the error of the estimate itself is far below a percent.
  assert.ok(estimate.meanCurvature.every((mean) => Math.abs(mean * radius - 1) < 0.02));
  assert.ok(estimate.gaussianCurvature.every((gaussian) => Math.abs(gaussian * radius ** 2 - 1) < 0.04));
  assert.ok(estimate.k1.every((k1, i) => k1 <= estimate.k2[i]));
  assert.ok(estimate.status.every((status) => status === PointStatus.OK));
}

// The CurvdError that a call rejects with.
export async function failure(promise) {
  const error = await promise.then(
    () => assert.fail("the call succeeded"),
    (reason) => reason,
  );
  assert.ok(error instanceof CurvdError, String(error));
  return error;
}

// Runs `use` against a server that reads the whole cloud, then plays `script(call)`.
export async function scripted(script, use) {
  const fake = new grpc.Server();
  fake.addService(CurvatureService.service, {
    estimateCurvature(call) {
      call.on("data", () => {});
      call.on("end", () => script(call));
    },
    getServerInfo: (_, callback) => callback(null, {}),
  });
  const port = await new Promise((resolve, reject) =>
    fake.bindAsync("127.0.0.1:0", grpc.ServerCredentials.createInsecure(), (error, bound) =>
      error ? reject(error) : resolve(bound),
    ),
  );
  try {
    return await use(`127.0.0.1:${port}`);
  } finally {
    fake.forceShutdown();
  }
}
