// Curvature of oriented point clouds, estimated by a curvd server: typed arrays in, typed arrays out.
export { estimateCurvature } from "./client.mjs";
export { CurvdError } from "./errors.mjs";
export { PointStatus } from "./results.mjs";
