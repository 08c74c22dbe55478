// Where the normals of a cloud come from, and which side of its surface is out.
import { show } from "./show.mjs";

const METHODS = {
  pca: "NORMAL_METHOD_PCA",
  "jet-1": "NORMAL_METHOD_JET_1",
  "jet-2": "NORMAL_METHOD_JET_2",
  "jet-4": "NORMAL_METHOD_JET_4",
};
const ORIENTATIONS = { consistent: "ORIENTATION_CONSISTENT", closed: "ORIENTATION_CLOSED" };

// Returns the contract's NormalOptions. Normals that are given stay as they are unless `orientation`, `viewpoint`,
// `viewpoints` or `direction` says which side is out; those that are not are estimated. Throws a TypeError, naming the
// option, for options that make no sense together.
export function normalOptions(hasNormals, { orientation, viewpoint, viewpoints, direction, method, neighborCount, radius }) {
  const sides = [orientation, viewpoint, viewpoints, direction].filter((side) => side !== undefined);
  if (sides.length > 1) throw new TypeError("orientation, viewpoint, viewpoints and direction exclude each other");
  const source = !hasNormals ? "NORMAL_SOURCE_ESTIMATE" : sides.length > 0 ? "NORMAL_SOURCE_ORIENT" : "NORMAL_SOURCE_GIVEN";
  return {
    source,
    ...side({ orientation, viewpoint, viewpoints, direction }),
    ...neighborhood(hasNormals, { method, neighborCount, radius }),
  };
}

function side({ orientation, viewpoint, viewpoints, direction }) {
  if (orientation !== undefined) {
    if (!Object.hasOwn(ORIENTATIONS, orientation)) {
      throw new TypeError(`orientation is ${show(orientation)}; it must be consistent or closed`);
    }
    return { orientation: ORIENTATIONS[orientation] };
  }
  if (viewpoint !== undefined) return { orientation: "ORIENTATION_VIEWPOINT", viewpoint: vector("viewpoint", viewpoint) };
  if (viewpoints !== undefined) return { orientation: "ORIENTATION_POINT_VIEWPOINTS" };
  if (direction !== undefined) return { orientation: "ORIENTATION_DIRECTION", direction: vector("direction", direction) };
  return {};
}

// The contract's Vector3. Throws a TypeError, naming the option, for what is no vector.
export function vector(name, value) {
  const [x, y, z, ...more] = value?.[Symbol.iterator] === undefined ? [] : value;
  if (![x, y, z].every(Number.isFinite) || more.length > 0) {
    throw new TypeError(`${name} is ${show(value)}; it must be three finite numbers`);
  }
  return { x, y, z };
}

function neighborhood(hasNormals, { method, neighborCount, radius }) {
  if (hasNormals && [method, neighborCount, radius].some((option) => option !== undefined)) {
    throw new TypeError("normals are given: a method, neighborCount or radius for them goes with normals = null");
  }
  if (neighborCount !== undefined && radius !== undefined) {
    throw new TypeError("neighborCount and radius of normals exclude each other");
  }
  if (method !== undefined && !Object.hasOwn(METHODS, method)) {
    const names = Object.keys(METHODS).join(", ");
    throw new TypeError(`the method of normals is ${show(method)}; it must be one of ${names}`);
  }
  return {
    ...(method !== undefined && { method: METHODS[method] }),
    ...(neighborCount !== undefined && { neighborCount }),
    ...(radius !== undefined && { radius }),
  };
}
