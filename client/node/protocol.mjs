// The contract, loaded from the package's .proto files; in a clone, from those of the repository.
import { existsSync } from "node:fs";
import { fileURLToPath } from "node:url";
import grpc from "@grpc/grpc-js";
import protoLoader from "@grpc/proto-loader";

const packed = fileURLToPath(new URL("./proto", import.meta.url));
const protos = existsSync(packed) ? packed : fileURLToPath(new URL("../../proto", import.meta.url));

const definition = protoLoader.loadSync(
  ["curvature/v1/curvature.proto", "google/rpc/status.proto", "google/rpc/error_details.proto"],
  {
    includeDirs: [protos],
    keepCase: false,
    longs: Number, // counts stay far below 2^53
    enums: String,
    defaults: true,
    oneofs: true,
  },
);

// The stub's constructor: new CurvatureService(address, credentials, options).
export const CurvatureService = grpc.loadPackageDefinition(definition).curvature.v1.CurvatureService;

// Decodes a serialized message of the given full name. Throws if the bytes are none, or the name is unknown.
export function decode(name, bytes) {
  return definition[name].deserialize(bytes);
}

// The names of an enum's values, in the contract's order.
export function enumValues(name) {
  return definition[name].type.value.map((value) => value.name);
}

// Names of the arrays of a ResultChunk, in the order of the contract.
export const RESULT_ARRAYS = definition["curvature.v1.ResultChunk"].type.field
  .filter((field) => field.type === "TYPE_BYTES")
  .map((field) => field.name);

// The quantities that a call may ask for: by their names here ("meanCurvature"), those of the contract's enum.
export const QUANTITIES = new Map(
  definition["curvature.v1.Quantity"].type.value
    .filter((value) => value.number !== 0)
    .map((value) => [toCamelCase(value.name.replace(/^QUANTITY_/, "").toLowerCase()), value.name]),
);

// Quantities that come as several arrays; each other one comes as an array of its own name.
const ARRAYS_OF = new Map([
  ["principalCurvatures", ["k1", "k2"]],
  ["principalDirections", ["d1", "d2"]],
  ["normals", ["normal"]],
  ["normalQuality", ["normalResidual", "normalVarianceRatio"]],
  ["standardErrors", ["meanCurvatureStandardError", "k1StandardError", "k2StandardError"]],
  ["estimatorWeights", ["avgHexagramWeight", "normalRegressionWeight", "jetWeight", "asoWeight"]],
]);
// The quantity that an array of another name comes with; undefined for others.
export const quantityOfArray = (array) => [...ARRAYS_OF.keys()].find((name) => ARRAYS_OF.get(name).includes(array));

// These come without being asked for; normals as well where the server makes them.
export const DEFAULT_QUANTITIES = Object.freeze([
  "meanCurvature",
  "gaussianCurvature",
  "principalCurvatures",
  "principalDirections",
  "radius",
]);
export const CURVATURE_ARRAYS = DEFAULT_QUANTITIES.flatMap((name) => ARRAYS_OF.get(name) ?? [name]);

// Names of the arrays, beside status, that a call must get which asks for those quantities. All of them if it asks for
// none, which is to ask for all: null, because an older server may not know one of them.
export function resultArrays(quantities = []) {
  return quantities.length === 0 ? null : quantities.flatMap((name) => ARRAYS_OF.get(name) ?? [name]);
}

function toCamelCase(name) {
  return name.replace(/_([a-z])/g, (_, letter) => letter.toUpperCase());
}
