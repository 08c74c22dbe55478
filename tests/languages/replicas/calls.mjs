// Makes calls as one Node.js program: calls.mjs client|function SERVER CALLS. Exits with 5 if one fails.
import { CurvatureClient, CurvdError, estimateCurvature } from "../../../client/node/index.mjs";

const [way, server, calls] = process.argv.slice(2);
const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]);
const normals = new Float32Array([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1]);
const client = new CurvatureClient(server);
try {
  for (let i = 0; i < Number(calls); i++) {
    if (way === "client") await client.estimateCurvature(positions, normals, { neighborCount: 4 });
    else await estimateCurvature(positions, normals, { server, neighborCount: 4 });
  }
} catch (error) {
  if (!(error instanceof CurvdError)) throw error;
  console.error(error.message);
  process.exitCode = 5;
} finally {
  client.close();
}
