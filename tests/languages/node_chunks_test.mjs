// Results that are iterated over as they come. Against a real curvd (CURVD_SERVER) and servers that misbehave.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { CurvatureClient, CurvdError } from "../../client/node/index.mjs";
import { scripted, sphere } from "./node_helpers.mjs";

const grpc = createRequire(new URL("../../client/node/", import.meta.url))("@grpc/grpc-js");

async function withClient(server, use) {
  const client = new CurvatureClient(server);
  try {
    return await use(client);
  } finally {
    client.close();
  }
}

async function failureOf(chunks) {
  const seen = [];
  try {
    for await (const chunk of chunks) seen.push(chunk);
  } catch (error) {
    assert.ok(error instanceof CurvdError, String(error));
    return { error, seen };
  }
  return assert.fail("the iteration succeeded");
}

const result = (firstIndex, pointCount) => ({ result: { firstIndex, pointCount, status: Buffer.alloc(pointCount, 1) } });

test("chunks together are what comes at once", async () => {
  await withClient(process.env.CURVD_SERVER, async (client) => {
    const cloud = sphere(60_000, 2);
    const options = { quantities: ["meanCurvature", "principalDirections"] };
    const whole = await client.estimateCurvature(...cloud, options);
    const chunks = client.estimateChunks(...cloud, options);
    let points = 0;
    let count = 0;
    for await (const { firstIndex, pointCount, ...arrays } of chunks) {
      assert.equal(chunks.summary, null);
      assert.equal(firstIndex, points);
      assert.deepEqual(Object.keys(arrays).sort(), ["d1", "d2", "meanCurvature", "status"]);
      for (const [name, array] of Object.entries(arrays)) {
        const width = array.length / pointCount;
        assert.deepEqual(array, whole[name].subarray(width * points, width * (points + pointCount)), name);
      }
      points += pointCount;
      count += 1;
    }
    assert.equal(points, 60_000);
    assert.ok(count > 2, `${count} chunks`);
    assert.deepEqual(chunks.summary.statusCounts, whole.summary.statusCounts);
    // Once more is one more call.
    let again = 0;
    for await (const { pointCount } of chunks) again += pointCount;
    assert.equal(again, 60_000);
  });
});

test("an empty cloud has no chunk and a summary", async () => {
  await withClient(process.env.CURVD_SERVER, async (client) => {
    const chunks = client.estimateChunks(new Float32Array(), new Float32Array());
    for await (const chunk of chunks) assert.fail(JSON.stringify(chunk));
    assert.equal(chunks.summary.pointCount, 0);
  });
});

test("who takes no chunks holds the server up, and who leaves cancels the call", async () => {
  const [chunkPoints, chunkCount] = [5_000, 200];
  let written = 0;
  let cancelled = false;
  const directions = Buffer.alloc(12 * chunkPoints);
  const script = async (call) => {
    call.on("cancelled", () => (cancelled = true));
    for (let i = 0; i < chunkCount && !cancelled; ++i) {
      written += 1;
      const chunk = result(i * chunkPoints, chunkPoints);
      Object.assign(chunk.result, { d1: directions, d2: directions });
      if (!call.write(chunk)) await new Promise((resolve) => call.once("drain", resolve));
    }
    call.end();
  };
  await scripted(script, (fake) =>
    withClient(fake, async (client) => {
      const positions = new Float32Array(3 * chunkPoints * chunkCount);
      for await (const { pointCount } of client.estimateChunks(positions, positions)) {
        assert.equal(pointCount, chunkPoints);
        let before = -1;
        // Until the server writes no more.
        while (before !== written) {
          before = written;
          await sleep(300);
        }
        // Buffers of Node.js, of HTTP/2 and of both sockets lie between: 25 MB would be all.
        assert.ok(written < chunkCount / 2, `${written} of ${chunkCount} chunks were written`);
        break;
      }
      const end = performance.now() + 5_000;
      while (!cancelled && performance.now() < end) await sleep(10);
      assert.ok(cancelled, "the server was not told");
    }),
  );
});

test("an error before the first chunk is tried again, and one after it ends the iteration", async () => {
  let calls = 0;
  const script = (call) => {
    calls += 1;
    const gone = { code: grpc.status.UNAVAILABLE, details: "Stream removed" };
    if (calls === 1) return call.emit("error", gone);
    call.write(result(0, 5));
    if (calls === 2) return setTimeout(() => call.emit("error", gone), 100);
    call.write(result(5, 5));
    call.write({ summary: { pointCount: 10 } });
    call.end();
  };
  await scripted(script, (fake) =>
    withClient(fake, async (client) => {
      const { error, seen } = await failureOf(client.estimateChunks(...sphere(10, 1)));
      assert.deepEqual([error.codeName, seen.length, calls], ["UNAVAILABLE", 1, 2]);
      const chunks = client.estimateChunks(...sphere(10, 1));
      let points = 0;
      for await (const { pointCount } of chunks) points += pointCount;
      assert.deepEqual([points, chunks.summary.pointCount, calls], [10, 10, 3]);
    }),
  );
});

test("breaches of the protocol are found where they are", async () => {
  const other = { result: { firstIndex: 5, pointCount: 5, status: Buffer.alloc(5, 1), radius: Buffer.alloc(20) } };
  const summary = { summary: { pointCount: 10 } };
  const breaches = [
    ["starts at 6, not 5", 1, [result(0, 5), result(6, 4), summary]],
    ["up to point 11", 1, [result(0, 5), result(5, 6), summary]],
    ["have the arrays status 1,radius 1", 1, [result(0, 5), other, summary]],
    ["5 results and a summary of 10", 1, [result(0, 5), summary]],
    ["without a summary", 2, [result(0, 5), result(5, 5)]],
  ];
  for (const [message, chunkCount, responses] of breaches) {
    const script = (call) => {
      responses.forEach((response) => call.write(response));
      call.end();
    };
    await scripted(script, (fake) =>
      withClient(fake, async (client) => {
        const { error, seen } = await failureOf(client.estimateChunks(...sphere(10, 1)));
        assert.equal(error.codeName, "INTERNAL");
        assert.ok(error.message.includes(message), `${error.message} should say: ${message}`);
        assert.equal(seen.length, chunkCount);
      }),
    );
  }
});

test("signals, a closed client and the caller's own errors end an iteration", async () => {
  const cloud = sphere(200_000, 1);
  const slow = { neighborCount: 2_000, estimator: "jet" };
  await withClient(process.env.CURVD_SERVER, async (client) => {
    const iterate = async (options) => {
      for await (const chunk of client.estimateChunks(...cloud, { ...slow, ...options })) assert.fail(String(chunk));
    };
    const controller = new AbortController();
    const onProgress = ({ phase }) => phase === "estimating" && controller.abort();
    await assert.rejects(iterate({ signal: controller.signal, onProgress }), { name: "AbortError" });
    const throwing = () => {
      throw new RangeError("enough");
    };
    await assert.rejects(iterate({ onProgress: throwing }), RangeError);
    await assert.rejects(iterate({ onProgress: () => client.close() }), /the client is closed/);
    await assert.rejects(iterate({}), /the client is closed/);
  });
});

test("arguments that make no request are refused at once", async () => {
  await withClient("127.0.0.1:1", async (client) => {
    const [positions, normals] = sphere(10, 1);
    assert.throws(() => client.estimateChunks(positions, normals, { neighbourCount: 9 }), /did you mean neighborCount/);
    assert.throws(() => client.estimateChunks(positions, normals.subarray(3)), TypeError);
    const { error } = await failureOf(client.estimateChunks(positions, normals, { maxAttempts: 1 }));
    assert.equal(error.codeName, "UNAVAILABLE");
  });
});

test("a server tells its health", async () => {
  await withClient(process.env.CURVD_SERVER, async (client) => assert.equal(await client.health(), "SERVING"));
  await withClient("127.0.0.1:1", async (client) => {
    await assert.rejects(client.health({ maxAttempts: 1 }), { codeName: "UNAVAILABLE" });
    await assert.rejects(client.health({ timeout: 9 }), TypeError);
  });
});
