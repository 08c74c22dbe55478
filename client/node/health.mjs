// Whether a server takes calls, by grpc.health.v1, whose messages are few enough to stand here.
import protoLoader from "@grpc/proto-loader";

const Check = { requestType: "HealthCheckRequest", responseType: "HealthCheckResponse" };
const ServingStatus = { values: { UNKNOWN: 0, SERVING: 1, NOT_SERVING: 2, SERVICE_UNKNOWN: 3 } };
const contract = {
  Health: { methods: { Check } },
  HealthCheckRequest: { fields: { service: { type: "string", id: 1 } } },
  HealthCheckResponse: { fields: { status: { type: "ServingStatus", id: 1 } }, nested: { ServingStatus } },
};
const nest = (names, nested) => names.reduceRight((inner, name) => ({ nested: { [name]: inner } }), { nested });
const definition = protoLoader.fromJSON(nest(["grpc", "health", "v1"], contract), { enums: String, defaults: true });
const { path, requestSerialize, responseDeserialize } = definition["grpc.health.v1.Health"].Check;

// Asks over the connections of a stub of another service, as its methods do: (request, metadata, options, callback).
export function checkHealth(stub, metadata, options, callback) {
  const request = { service: "curvature.v1.CurvatureService" };
  return stub.makeUnaryRequest(path, requestSerialize, responseDeserialize, request, metadata, options, (error, response) =>
    callback(error, response?.status),
  );
}
