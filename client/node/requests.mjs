// What a call sends, from the arguments of the function that makes it.
import { checkCurvatureOptions, checkNormalsOptions } from "./arguments.mjs";
import { commonHeader, curvatureHeader } from "./headers.mjs";
import { normalOptions } from "./normals.mjs";
import { resultArrays } from "./protocol.mjs";
import { kindOf } from "./show.mjs";

// Each returns what callOnce and receiveChunks take. Throws a TypeError if the arguments make no request.
export function curvatureRequest(positions, normals, options) {
  checkCurvatureOptions(options);
  const normalsFrom = {
    ...options,
    method: options.normalMethod,
    neighborCount: options.normalNeighborCount,
    radius: options.normalRadius,
  };
  return requestOf(positions, normals, curvatureHeader(options), normalsFrom, options);
}

export function normalsRequest(positions, normals, options) {
  checkNormalsOptions(options);
  const asked = { ...options, quantities: ["normals", "normalQuality"] };
  return requestOf(positions, normals, commonHeader(asked), options, asked);
}

function requestOf(positions, normals, header, normalsFrom, options) {
  const cloud = {
    positions,
    normals,
    viewpoints: options.viewpoints ?? null,
    curvatureDirections: options.curvatureDirections ?? null,
  };
  checkArrays(cloud);
  header.pointCount = cloud.positions.length / 3;
  header.scalarType = cloud.positions instanceof Float64Array ? "SCALAR_TYPE_FLOAT64" : "SCALAR_TYPE_FLOAT32";
  header.normals = normalOptions(cloud.normals !== null, normalsFrom);
  return { header, cloud, arrays: resultArrays(options.quantities), onProgress: options.onProgress };
}

function checkArrays({ positions, normals, viewpoints, curvatureDirections }) {
  if (!(positions instanceof Float32Array || positions instanceof Float64Array)) {
    throw new TypeError(`positions is ${kindOf(positions)}; it must be a Float32Array or a Float64Array`);
  }
  const hint = kindOf(normals) === "an object" ? "; options are the third argument" : "";
  checkAlike("normals", normals, positions, `, or null to have normals estimated${hint}`);
  checkAlike("viewpoints", viewpoints, positions);
  checkAlike("curvatureDirections", curvatureDirections, positions);
  for (const [name, array] of Object.entries({ normals, viewpoints, curvatureDirections })) {
    const length = array?.length ?? positions.length;
    if (positions.length % 3 !== 0 || positions.length !== length) {
      throw new TypeError(`positions has ${positions.length} scalars and ${name} ${length}; both need 3 for each point`);
    }
  }
}

function checkAlike(name, array, positions, otherwise = "") {
  if (array === null || array?.constructor === positions.constructor) return;
  throw new TypeError(`${name} is ${kindOf(array)}; it must be ${kindOf(positions)}, as positions is${otherwise}`);
}
