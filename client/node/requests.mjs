// What a call sends, from the arguments of the function that makes it.
import { checkCurvatureOptions, checkNormalsOptions } from "./arguments.mjs";
import { commonHeader, curvatureHeader } from "./headers.mjs";
import { normalOptions } from "./normals.mjs";
import { resultArrays } from "./protocol.mjs";

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
  const isFloats = positions instanceof Float32Array || positions instanceof Float64Array;
  const isAlike = (array) => array === null || array?.constructor === positions.constructor;
  if (!isFloats || !isAlike(normals)) {
    throw new TypeError(
      "positions and normals must both be Float32Array or both be Float64Array; to have normals estimated, give null",
    );
  }
  if (!isAlike(viewpoints)) throw new TypeError("viewpoints must be of the type of positions");
  if (!isAlike(curvatureDirections)) throw new TypeError("curvatureDirections must be of the type of positions");
  for (const [name, array] of Object.entries({ normals, viewpoints, curvatureDirections })) {
    const length = array?.length ?? positions.length;
    if (positions.length % 3 !== 0 || positions.length !== length) {
      throw new TypeError(`positions has ${positions.length} scalars and ${name} ${length}; both need 3 for each point`);
    }
  }
}
