// The contract's CloudHeader, from the options of a call.
import { vector } from "./normals.mjs";
import { enumValues, QUANTITIES, quantityOfArray } from "./protocol.mjs";
import { isTypedArray, show } from "./show.mjs";

// Two estimators have shorter names than the contract gives them.
const SHORT_NAMES = { "jet-fitting": "jet", "algebraic-shape-operator": "aso" };

// Every estimator by the name that people use: that of the contract without prefix, in small letters, - for _.
const ESTIMATORS = Object.fromEntries(
  enumValues("curvature.v1.Estimator")
    .filter((value) => value !== "ESTIMATOR_UNSPECIFIED")
    .map((value) => {
      const name = value.slice("ESTIMATOR_".length).toLowerCase().replaceAll("_", "-");
      return [SHORT_NAMES[name] ?? name, value];
    }),
);

// The names by which calls take what the server tells of; one of a newer contract stays as it is.
export function estimatorNames(values) {
  const names = new Map(Object.entries(ESTIMATORS).map(([name, value]) => [value, name]));
  return values.map((value) => names.get(value) ?? value);
}

const PRIORITIES = { interactive: "PRIORITY_INTERACTIVE", batch: "PRIORITY_BATCH" };

function quantityNames(quantities = []) {
  const names = Array.isArray(quantities) ? quantities.map((name) => QUANTITIES.get(name)) : [undefined];
  if (names.includes(undefined) || new Set(names).size !== names.length) {
    const array = Array.isArray(quantities) ? quantities.find(quantityOfArray) : undefined;
    if (array !== undefined) {
      throw new TypeError(`quantities has ${show(array)}, which comes with ${show(quantityOfArray(array))}: ask for that`);
    }
    const known = [...QUANTITIES.keys()].join(", ");
    throw new TypeError(
      `quantities is ${show(quantities)}; it must be an array that has each of ${known} at most once`,
    );
  }
  return names;
}

// The contract's AutomaticScale; undefined where the caller says how large neighborhoods are.
function scaleOf({ estimator, neighborCount, radius, neighborCountRange, maxRadius, scalePerCloud }) {
  if (radius !== undefined && (estimator === "auto" || neighborCount === "auto")) {
    throw new TypeError('radius does not go with "auto"; maxRadius says how far an estimate looks at most');
  }
  const leavesOpen = estimator === "auto" && neighborCount === undefined;
  if (neighborCount !== "auto" && !leavesOpen) {
    if (neighborCountRange !== undefined || maxRadius !== undefined || scalePerCloud) {
      throw new TypeError('neighborCountRange, maxRadius and scalePerCloud need neighborCount: "auto"');
    }
    return undefined;
  }
  const isCount = (count) => Number.isInteger(count) && count > 0 && count < 2 ** 32;
  const range = itemsOf(neighborCountRange);
  if (neighborCountRange !== undefined && !(range.length === 2 && range.every(isCount))) {
    throw new TypeError(
      `neighborCountRange is ${show(neighborCountRange)}; it must be [fewest, most] points, as [16, 2048]`,
    );
  }
  const [leastNeighborCount = 0, mostNeighborCount = 0] = range;
  return { leastNeighborCount, mostNeighborCount, maxRadius: maxRadius ?? 0, perCloud: scalePerCloud ?? false };
}

// Several numbers of neighbors; none where there is one neighborhood.
function countsOf({ estimator, neighborCount, neighborCounts, radius }) {
  if (neighborCounts === undefined) return [];
  if (estimator === "auto" || neighborCount !== undefined || radius !== undefined) {
    throw new TypeError("neighborCounts exclude neighborCount, radius and the estimator auto");
  }
  const counts = itemsOf(neighborCounts);
  const ascends = (count, i) => Number.isInteger(count) && count < 2 ** 32 && count > (i === 0 ? 0 : counts[i - 1]);
  if (counts.length === 0 || !counts.every(ascends)) {
    throw new TypeError(`neighborCounts is ${show(neighborCounts)}; it must be an array of numbers that ascend`);
  }
  return counts;
}

// What an array or a typed array holds; nothing of other values.
function itemsOf(array) {
  return Array.isArray(array) || isTypedArray(array) ? Array.from(array) : [];
}

// The one direction of normal curvature, as a part of a CloudHeader; none where each point has its own.
function directionOf({ quantities = [], curvatureDirection, curvatureDirections }) {
  const isAsked = Array.isArray(quantities) && quantities.includes("normalCurvature");
  const given = [curvatureDirection, curvatureDirections].filter((direction) => direction !== undefined);
  if (given.length !== (isAsked ? 1 : 0)) {
    throw new TypeError(
      isAsked
        ? 'the quantity "normalCurvature" needs curvatureDirection or curvatureDirections, and not both'
        : 'curvatureDirection and curvatureDirections need "normalCurvature" among the quantities',
    );
  }
  return curvatureDirection === undefined ? {} : { curvatureDirection: vector("curvatureDirection", curvatureDirection) };
}

// Throws a TypeError, naming the option, for options that make no sense.
export function curvatureHeader(options) {
  const { estimator = "avg-hexagram", neighborCount, radius } = options;
  if (typeof estimator !== "string" || !Object.hasOwn(ESTIMATORS, estimator)) {
    const names = Object.keys(ESTIMATORS).join(", ");
    throw new TypeError(`estimator is ${show(estimator)}; it must be one of ${names}`);
  }
  const neighborCounts = countsOf(options);
  const automaticScale = scaleOf(options);
  if (neighborCount !== undefined && radius !== undefined) {
    throw new TypeError("neighborCount and radius exclude each other");
  }
  if (typeof neighborCount === "string" && neighborCount !== "auto") {
    throw new TypeError(`neighborCount is ${show(neighborCount)}; it must be a number or "auto"`);
  }
  return {
    ...commonHeader(options),
    ...directionOf(options),
    options: {
      estimator: ESTIMATORS[estimator],
      ...(automaticScale !== undefined && { automaticScale }),
      ...(neighborCount !== undefined && neighborCount !== "auto" && { neighborCount }),
      ...(radius !== undefined && { radius }),
      neighborCounts,
      triangleCount: options.triangleCount ?? 0,
      rotationCount: options.rotationCount ?? 0,
      jetDegree: options.jetDegree ?? 0,
      regressionDegree: options.regressionDegree ?? 0,
      evenWeights: options.evenWeights ?? false,
      project: options.project ?? false,
      seed: options.seed ?? 0,
      ...(options.averageNormalWeight !== undefined && { averageNormalWeight: options.averageNormalWeight }),
    },
    opposedNormalsPolicy: options.rejectOpposedNormals ? "OPPOSED_NORMALS_POLICY_REJECT" : "OPPOSED_NORMALS_POLICY_MARK",
  };
}

// What curvature and normals are asked for with alike.
export function commonHeader(options) {
  if (options.priority !== undefined && !Object.hasOwn(PRIORITIES, options.priority)) {
    throw new TypeError(`priority is ${show(options.priority)}; it must be interactive or batch`);
  }
  return {
    quantities: quantityNames(options.quantities),
    invalidPointPolicy: options.skipInvalid ? "INVALID_POINT_POLICY_SKIP" : "INVALID_POINT_POLICY_REJECT",
    priority: PRIORITIES[options.priority] ?? "PRIORITY_UNSPECIFIED",
    requestTag: options.requestTag ?? "",
  };
}
