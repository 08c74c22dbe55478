// Curvature of point clouds, and their normals, from a curvd server: typed arrays in, typed arrays out.
export { CurvatureClient } from "./client.mjs";
export { CurvdError } from "./errors.mjs";
export { estimateCurvature, estimateNormals } from "./functions.mjs";
export { readPointCloud } from "./las.mjs";
export { DEFAULT_QUANTITIES } from "./protocol.mjs";
export { PointStatus } from "./results.mjs";
