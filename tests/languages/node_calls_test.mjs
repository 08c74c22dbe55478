// How the Node.js client calls: connections, replicas, progress, signals, options. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { createRequire } from "node:module";
import net from "node:net";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { isLocal, splitServers } from "../../client/node/addresses.mjs";
import { CurvatureClient, CurvdError, estimateCurvature, estimateNormals } from "../../client/node/index.mjs";
import { failure, scripted, sphere } from "./node_helpers.mjs";

const grpc = createRequire(new URL("../../client/node/", import.meta.url))("@grpc/grpc-js");
const server = process.env.CURVD_SERVER;

test("a client keeps its connection, and estimates, makes normals and tells of its server", async () => {
  const client = new CurvatureClient(server);
  const [positions, normals] = sphere(2_000, 2);
  const { meanCurvature } = await client.estimateCurvature(positions, normals);
  assert.ok(meanCurvature.every((mean) => Math.abs(mean - 0.5) < 0.02));
  const made = await client.estimateNormals(positions);
  assert.ok(made.normal.every((component, i) => Math.abs(component - normals[i]) < 0.02));
  const info = await client.info();
  assert.match(info.version, /^\d+\.\d+\.\d+/);
  assert.ok(["jet", "aso", "avg-hexagram", "auto"].every((name) => info.estimators.includes(name)), info.estimators);
  client.close();
  client.close();
  await assert.rejects(client.info(), /the client is closed/);
});

test("calls go to replicas in turn", async () => {
  for (const join of [(a, b) => `${a},${b}`, (a, b) => `ipv4:${a},${b}`]) {
    const counts = { one: 0, two: 0 };
    const counting = (name) => (call) => {
      counts[name] += 1;
      call.write({ summary: { pointCount: 0 } });
      call.end();
    };
    await scripted(counting("one"), (one) =>
      scripted(counting("two"), async (two) => {
        const none = new Float32Array();
        const client = new CurvatureClient(join(one, two));
        for (let i = 0; i < 50; ++i) await client.estimateCurvature(none, none);
        client.close();
        for (let i = 0; i < 50; ++i) await estimateCurvature(none, none, { server: join(one, two) });
      }),
    );
    assert.equal(counts.one + counts.two, 100);
    assert.ok(Math.min(counts.one, counts.two) >= 40, JSON.stringify(counts));
  }
});

test("a server that never answered is given up early, unless the caller has more time", async () => {
  const [positions, normals] = sphere(10, 1);
  const elapsed = async (options) => {
    const start = performance.now();
    const client = new CurvatureClient("127.0.0.1:1");
    const error = await failure(client.estimateCurvature(positions, normals, options));
    assert.equal(error.codeName, "UNAVAILABLE");
    assert.equal(error.answered, false);
    client.close();
    return performance.now() - start;
  };
  assert.ok((await elapsed({})) < 2_000);
  assert.ok((await elapsed({ connectTimeoutMs: 2_500 })) > 1_200);
});

test("each replica is tried, however long the first took", async () => {
  const [positions, normals] = sphere(100, 1);
  for (let i = 0; i < 20; ++i) {
    const client = new CurvatureClient(`127.0.0.1:1,${server}`);
    const { status } = await client.estimateCurvature(positions, normals, { connectTimeoutMs: 0 });
    assert.equal(status.length, 100);
    client.close();
  }
});

test("a signal ends a call that runs, and one that has not begun", async () => {
  const [positions, normals] = sphere(200_000, 1);
  const controller = new AbortController();
  const onProgress = ({ phase }) => phase === "estimating" && controller.abort();
  const slow = { server, neighborCount: 2_000, estimator: "jet", signal: controller.signal, onProgress };
  await assert.rejects(estimateCurvature(positions, normals, slow), { name: "AbortError" });
  await assert.rejects(estimateCurvature(positions, normals, slow), { name: "AbortError" });
});

test("any reason of a signal comes back as it is", async () => {
  const controller = new AbortController();
  const onProgress = () => controller.abort(null);
  const options = { server, neighborCount: 4_000, signal: controller.signal, onProgress };
  const reason = await estimateCurvature(...sphere(200_000, 1), options).catch((error) => error);
  assert.equal(reason, null);
});

test("credentials of one's own serve one call, and its connection is closed", async (context) => {
  const [host, port] = server.split(":");
  const relay = net.createServer((near) => {
    const far = net.connect(Number(port), host);
    near.pipe(far).pipe(near);
    context.after(() => near.destroy());
    near.on("error", () => far.destroy());
    far.on("error", () => near.destroy());
  });
  context.after(() => relay.close());
  await once(relay.listen(0, "127.0.0.1"), "listening");
  const count = promisify(relay.getConnections.bind(relay));
  const none = new Float32Array();
  const options = { server: `127.0.0.1:${relay.address().port}`, credentials: grpc.credentials.createInsecure() };
  for (let i = 0; i < 3; ++i) await estimateCurvature(none, none, options);
  const end = performance.now() + 3_000;
  while ((await count()) > 0 && performance.now() < end) await sleep(20);
  assert.equal(await count(), 0);
});

test("a signal ends the pauses between tries", async () => {
  const signal = AbortSignal.timeout(300);
  const start = performance.now();
  const options = { server: "127.0.0.1:1", signal, connectTimeoutMs: 60_000, maxAttempts: 20 };
  await assert.rejects(estimateCurvature(...sphere(10, 1), options), { name: "TimeoutError" });
  assert.ok(performance.now() - start < 1_500);
});

test("progress names phases and counts points", async () => {
  const seen = [];
  const [positions, normals] = sphere(200_000, 1);
  await estimateCurvature(positions, normals, { server, neighborCount: 4_000, onProgress: (each) => seen.push(each) });
  assert.ok(seen.some(({ phase }) => phase === "estimating"));
  assert.ok(seen.every((each) => each.pointCount === 200_000 && each.pointsEstimated <= 200_000));
  assert.equal(seen.at(-1).pointsEstimated, 200_000);
});

test("progress ends with all points", async () => {
  const cloud = sphere(100, 1); // too small for the server to tell progress
  const seen = [];
  const options = { onProgress: (each) => seen.push(each) };
  await estimateCurvature(...cloud, { server, ...options });
  const client = new CurvatureClient(server);
  for await (const chunk of client.estimateChunks(...cloud, options)) assert.ok(chunk);
  client.close();
  const last = { phase: "sending", pointsReceived: 100, pointsEstimated: 100, pointCount: 100 };
  assert.deepEqual(seen.filter(({ phase }) => phase === "sending"), [last, last]);
});

test("what a caller's function throws ends the call", async () => {
  const onProgress = () => {
    throw new RangeError("enough");
  };
  const [positions, normals] = sphere(200_000, 1);
  const options = { server, neighborCount: 4_000, onProgress };
  await assert.rejects(estimateCurvature(positions, normals, options), RangeError);
});

test("a failure of another call that a caller's function throws is no reason to try again", async () => {
  let tries = 0;
  const onProgress = () => {
    ++tries;
    throw new CurvdError(grpc.status.UNAVAILABLE, "elsewhere", { transient: true });
  };
  const options = { server, neighborCount: 4_000, onProgress };
  await assert.rejects(estimateCurvature(...sphere(200_000, 1), options), /elsewhere/);
  assert.equal(tries, 1);
});

test("what a caller's promise rejects with ends the call", async () => {
  const onProgress = async () => {
    throw new RangeError("enough");
  };
  const cloud = sphere(200_000, 1);
  const options = { server, neighborCount: 4_000, onProgress };
  await assert.rejects(estimateCurvature(...cloud, options), RangeError);
  const client = new CurvatureClient(server);
  const iterate = async () => {
    for await (const chunk of client.estimateChunks(...cloud, { neighborCount: 4_000, onProgress })) assert.ok(chunk);
  };
  await assert.rejects(iterate(), RangeError);
  client.close();
});

// Nobody waits for a promise that is settled later.
test("a promise that rejects after the call is nobody's error", async () => {
  let reject;
  const late = new Promise((_, refuse) => (reject = refuse));
  const script = (call) => {
    call.write({ progress: { phase: "PHASE_ESTIMATING" } });
    call.write({ summary: { pointCount: 0 } });
    call.end();
  };
  const none = new Float32Array();
  await scripted(script, (fake) => estimateCurvature(none, none, { server: fake, onProgress: () => late }));
  reject(new RangeError("late"));
  await sleep(0); // an unhandled rejection would end the process now
});

test("options that do not exist, or are of another type, are refused before a call", async () => {
  const [positions, normals] = sphere(10, 1);
  const refusals = [
    [{ neighbourCount: 9 }, /has no option neighbourCount: did you mean neighborCount\?/],
    [{ timeout: 9 }, /has no option timeout: did you mean timeoutMs\?/],
    [{ xyzzy: 9 }, /has no option xyzzy$/],
    [{ neighborCount: 1.5 }, /neighborCount is 1.5; it must be a whole number/],
    [{ neighborCount: 2 ** 32 + 50 }, /neighborCount is 4294967346; it must be a whole number from 1 to 4294967295/],
    [{ neighborCount: 0 }, /neighborCount is 0; it must be a whole number from 1/],
    [{ rotationCount: 0 }, /rotationCount is 0; it must be a whole number from 1/],
    [{ triangleCount: 2 ** 32 }, /triangleCount is 4294967296; it must be/],
    [{ seed: 2n ** 64n }, /seed is 18446744073709551616n; it must be/],
    [{ neighborCount: -1 }, /neighborCount is -1/],
    [{ radius: "1" }, /radius is "1"; it must be a number/],
    [{ skipInvalid: 1 }, /skipInvalid is 1; it must be true or false/],
    [{ timeoutMs: 0 }, /timeoutMs is 0; it must be a number of milliseconds above 0/],
    [{ signal: {} }, /signal is {}; it must be an AbortSignal/],
    [{ requestTag: ["a", 2n, NaN, null, {}] }, /requestTag is \["a",2n,NaN,null,{}\]; it must be a string/],
    [{ requestTag: new Map() }, /requestTag is Map {}; it must be a string/],
    [{ maxAttempts: 0 }, /maxAttempts is 0; it must be a whole number from 1/],
  ];
  for (const [options, message] of refusals) {
    await assert.rejects(estimateCurvature(positions, normals, { server, ...options }), (error) => {
      assert.ok(error instanceof TypeError, String(error));
      assert.match(error.message, message);
      return true;
    });
  }
  await assert.rejects(estimateNormals(positions, null, { server, estimator: "jet" }), /has no option estimator/);
  for (const options of [50, null, [50]]) {
    await assert.rejects(estimateCurvature(positions, normals, options), /options is .*; it must be an object/);
  }
  const client = new CurvatureClient(server);
  await assert.rejects(client.estimateCurvature(positions, normals, { server }), /server: it is an option of the client/);
  client.close();
  assert.throws(() => new CurvatureClient(server, { tls: true }), /has no option tls/);
});

test("messages show the beginning of long values", async () => {
  const positions = new Float32Array(300_000);
  const circle = {};
  circle.circle = circle;
  const text = "x".repeat(1_000_000);
  const refusals = [
    [{ viewpoint: positions }, /^viewpoint is Float32Array\(300000\) \[0,0,.*,\.\.\.; it must be three/],
    [{ viewpoint: Array.from(positions) }, /^viewpoint is \[0,0,.*0,?\.\.\.; it must be three/],
    [{ viewpoint: circle }, /^viewpoint is {"circle":.*{"circle":\.\.\.}}}; it must be three/],
    [{ radius: text }, /^radius is "x+\.\.\.; it must be a number/],
    [{ radius: () => positions.map(() => 1) }, /^radius is a function; it must be a number/],
    [{ estimator: text }, /^estimator is "x+\.\.\.; it must be one of/],
    [{ quantities: Array.from(positions) }, /^quantities is \[0,.*\.\.\.; it must be an array/],
    [{ neighborCounts: positions }, /^neighborCounts is Float32Array\(300000\) \[0,.*\.\.\.; it must be an array/],
    [{ server: `http://${text}` }, /^server "http:\/\/x+\.\.\. is a URL/],
    [{ server: positions }, /^server is Float32Array\(300000\) \[0,.*\.\.\.; it must be a string/],
  ];
  for (const [options, message] of refusals) {
    await assert.rejects(estimateCurvature(positions, null, options), (error) => {
      assert.ok(error instanceof TypeError, String(error));
      assert.match(error.message, message);
      assert.ok(error.message.length < 600, `${error.message.length} characters`);
      return true;
    });
  }
});

// gRPC's own error for a deadline that is too far would end the process.
test("a timeout of centuries is none", async () => {
  const [positions, normals] = sphere(100, 1);
  for (const timeoutMs of [1e15, 1e300, Infinity]) {
    const { status } = await estimateCurvature(positions, normals, { server, timeoutMs });
    assert.equal(status[0], 1);
  }
});

test("servers get the default port, and others a reason", () => {
  assert.deepEqual(splitServers("localhost"), ["localhost:50061"]);
  assert.deepEqual(splitServers("a:1, b"), ["a:1", "b:50061"]);
  assert.deepEqual(splitServers("ipv4:10.0.0.1:1,10.0.0.2"), ["ipv4:10.0.0.1:1,10.0.0.2:50061"]);
  assert.deepEqual(splitServers("dns:///curvd.example"), ["dns:///curvd.example:50061"]);
  assert.deepEqual(splitServers("dns:curvd.example:7"), ["dns:curvd.example:7"]);
  assert.deepEqual(splitServers("::1,[::1]:7"), ["[::1]:50061", "[::1]:7"]);
  assert.deepEqual(splitServers("unix:/run/curvd"), ["unix:/run/curvd"]);
  for (const wrong of ["", "a,", ":50061", "a:", "a:0", "a:65536", "a:x"]) {
    assert.throws(() => splitServers(wrong), TypeError, wrong);
  }
  assert.throws(() => splitServers("http://a:1"), /"http:\/\/a:1" is a URL; it must be HOST or HOST:PORT.*without http:\/\/$/);
  assert.throws(() => splitServers("a, HTTPS://b"), /is a URL;.*TLS has an option of its own$/);
  for (const url of ["foo:///x", "foo://x:1", "xds:///x", "DNS:///x"]) {
    assert.throws(() => splitServers(url), /^TypeError: server "\w+:\/+x(:1)?" is a URL; it must be HOST.*, without \w+:\/+$/);
  }
  assert.deepEqual(splitServers("dns://10.0.0.1/curvd.example"), ["dns://10.0.0.1/curvd.example:50061"]);
  assert.ok(["localhost:1", "[::1]:1", "unix:/x", "ipv4:127.0.0.1:1,127.0.0.2:1"].every(isLocal));
  assert.ok(!["localhost.example:1", "ipv4:127.0.0.1:1,10.0.0.1:1", "dns:///curvd.example:1"].some(isLocal));
});

test("kept connections do not keep a program alive", async () => {
  const index = fileURLToPath(new URL("../../client/node/index.mjs", import.meta.url));
  const program = `import { estimateCurvature } from ${JSON.stringify(index)};
    const none = new Float32Array();
    await estimateCurvature(none, none, { server: ${JSON.stringify(server)} });`;
  const child = spawn(process.execPath, ["--input-type=module", "--eval", program], { stdio: "inherit" });
  const watchdog = setTimeout(() => child.kill(), 5_000);
  const [code] = await once(child, "exit");
  clearTimeout(watchdog);
  assert.equal(code, 0);
});
