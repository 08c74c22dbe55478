// Types of the package; index.mjs and functions.mjs tell what the options mean.
import type { ChannelCredentials } from "@grpc/grpc-js";

export type Floats = Float32Array | Float64Array;
export type Vector = readonly [number, number, number];
export type Counts = readonly number[] | Uint8Array | Uint16Array | Uint32Array | Int8Array | Int16Array | Int32Array | Floats;
export type EstimatorName =
  | "avg-hexagram"
  | "hexagram"
  | "uniform"
  | "independent"
  | "delaunay"
  | "jet"
  | "aso"
  | "normal-regression"
  | "auto";
export type NormalMethod = "pca" | "jet-1" | "jet-2" | "jet-4";
export type Quantity =
  | "meanCurvature"
  | "gaussianCurvature"
  | "principalCurvatures"
  | "principalDirections"
  | "radius"
  | "normals"
  | "normalQuality"
  | "shapeIndex"
  | "curvedness"
  | "standardErrors"
  | "chosenNeighborCount"
  | "estimatorWeights"
  | "normalCurvature";

export interface Security {
  tls?: boolean | undefined;
  caFile?: string | URL | undefined;
  certFile?: string | URL | undefined;
  keyFile?: string | URL | undefined;
  serverName?: string | undefined;
  token?: string | undefined;
  sendTokenInPlainText?: boolean | undefined;
}

export interface ConnectionOptions {
  security?: Security | undefined;
  credentials?: ChannelCredentials | undefined;
}

export interface CallOptions {
  timeoutMs?: number | undefined;
  maxAttempts?: number | undefined;
  connectTimeoutMs?: number | undefined;
  signal?: AbortSignal | undefined;
}

export interface Progress {
  phase: string;
  pointsReceived: number;
  pointsEstimated: number;
  pointCount: number;
}

export interface CloudOptions extends CallOptions {
  onProgress?: ((progress: Progress) => void | Promise<void>) | undefined;
  orientation?: "consistent" | "closed" | undefined;
  viewpoint?: Vector | undefined;
  viewpoints?: Floats | undefined;
  direction?: Vector | undefined;
  skipInvalid?: boolean | undefined;
  priority?: "interactive" | "batch" | undefined;
  requestTag?: string | undefined;
}

export interface CurvatureOptions extends CloudOptions {
  estimator?: EstimatorName | undefined;
  neighborCount?: number | "auto" | undefined;
  neighborCounts?: Counts | undefined;
  radius?: number | undefined;
  neighborCountRange?: readonly [number, number] | undefined;
  maxRadius?: number | undefined;
  scalePerCloud?: boolean | undefined;
  triangleCount?: number | undefined;
  seed?: number | undefined;
  rotationCount?: number | undefined;
  jetDegree?: number | undefined;
  regressionDegree?: number | undefined;
  evenWeights?: boolean | undefined;
  project?: boolean | undefined;
  averageNormalWeight?: number | undefined;
  normalMethod?: NormalMethod | undefined;
  normalNeighborCount?: number | undefined;
  normalRadius?: number | undefined;
  quantities?: readonly Quantity[] | undefined;
  curvatureDirection?: Vector | undefined;
  curvatureDirections?: Floats | undefined;
  rejectOpposedNormals?: boolean | undefined;
}

export interface NormalsOptions extends CloudOptions {
  method?: NormalMethod | undefined;
  neighborCount?: number | undefined;
  radius?: number | undefined;
}

// Of the contract (proto/curvature/v1/curvature.proto), in camelCase, enums as strings; here, what programs read most.
export interface Summary {
  pointCount: number;
  statusCounts: Record<string, number>;
  warnings: { code: string; message: string }[];
  [field: string]: unknown;
}

export interface ServerInfo {
  version: string;
  estimators: (EstimatorName | string)[];
  [field: string]: unknown;
}

export type Health = "SERVING" | "NOT_SERVING" | "UNKNOWN" | "SERVICE_UNKNOWN";

export interface Results {
  meanCurvature?: Float32Array;
  gaussianCurvature?: Float32Array;
  k1?: Float32Array;
  k2?: Float32Array;
  d1?: Float32Array;
  d2?: Float32Array;
  radius?: Float32Array;
  normal?: Float32Array;
  normalResidual?: Float32Array;
  normalVarianceRatio?: Float32Array;
  shapeIndex?: Float32Array;
  curvedness?: Float32Array;
  meanCurvatureStandardError?: Float32Array;
  k1StandardError?: Float32Array;
  k2StandardError?: Float32Array;
  chosenNeighborCount?: Float32Array;
  avgHexagramWeight?: Float32Array;
  normalRegressionWeight?: Float32Array;
  jetWeight?: Float32Array;
  asoWeight?: Float32Array;
  normalCurvature?: Float32Array;
  status: Uint8Array;
}

// At one of neighborCounts.
export interface ScaleResults extends Results {
  neighborCount: number;
}

export interface Estimate extends Results {
  summary: Summary;
}

// With neighborCounts, in their order.
export interface ScalesEstimate {
  scales: ScaleResults[];
  summary: Summary;
}

// The results of some points, from firstIndex on.
export interface ResultChunk extends Results {
  firstIndex: number;
  pointCount: number;
  neighborCount?: number; // with neighborCounts
}

// Each iteration is a call; the summary is there once one has ended.
export interface ResultChunks extends AsyncIterable<ResultChunk> {
  summary: Summary | null;
}

export interface Normals {
  normal: Float32Array;
  normalResidual: Float32Array;
  normalVarianceRatio: Float32Array;
  status: Uint8Array;
  summary: Summary;
}

export class CurvatureClient {
  constructor(server?: string, options?: ConnectionOptions);
  estimateCurvature(
    positions: Floats,
    normals: Floats | null,
    options: CurvatureOptions & { neighborCounts: Counts },
  ): Promise<ScalesEstimate>;
  estimateCurvature(positions: Floats, normals: Floats | null, options?: CurvatureOptions): Promise<Estimate>;
  estimateNormals(positions: Floats, normals?: Floats | null, options?: NormalsOptions): Promise<Normals>;
  estimateChunks(positions: Floats, normals: Floats | null, options?: CurvatureOptions): ResultChunks;
  info(options?: CallOptions): Promise<ServerInfo>;
  health(options?: CallOptions): Promise<Health>;
  close(): void;
}

export interface ServerOptions extends ConnectionOptions {
  server?: string | undefined;
}

export function estimateCurvature(
  positions: Floats,
  normals: Floats | null,
  options: CurvatureOptions & ServerOptions & { neighborCounts: Counts },
): Promise<ScalesEstimate>;
export function estimateCurvature(
  positions: Floats,
  normals: Floats | null,
  options?: CurvatureOptions & ServerOptions,
): Promise<Estimate>;
export function estimateNormals(
  positions: Floats,
  normals?: Floats | null,
  options?: NormalsOptions & ServerOptions,
): Promise<Normals>;

export interface PointCloud {
  positions: Float64Array;
  normals: Float64Array | null;
  pointCount: number;
}

export function readPointCloud(file: string | URL | Uint8Array): Promise<PointCloud>;

export class CurvdError extends Error {
  readonly code: number;
  readonly codeName: string;
  readonly details: string;
  readonly reason: string;
  readonly metadata: Record<string, string>;
  readonly retryAfter: number | null;
  readonly transient: boolean;
  readonly answered: boolean;
}

export const DEFAULT_QUANTITIES: readonly Quantity[];

export const PointStatus: Readonly<{
  OK: 1;
  TOO_FEW_NEIGHBORS: 2;
  DEGENERATE_AREA: 3;
  INVALID_INPUT: 4;
  INCONSISTENT_NORMALS: 5;
  SINGULAR_FIT: 6;
  OPPOSED_NORMALS: 7;
  OUTLIER: 8;
}>;
