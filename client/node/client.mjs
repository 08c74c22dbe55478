// Calls that try again, over connections that are kept.
import { setMaxListeners } from "node:events";
import { DEFAULT_SERVER, splitServers } from "./addresses.mjs";
import { checkCallOptions, checkConnectionOptions } from "./arguments.mjs";
import { callOnce } from "./call.mjs";
import { receiveChunks } from "./chunks.mjs";
import { fromServiceError } from "./errors.mjs";
import { estimatorNames } from "./headers.mjs";
import { checkHealth } from "./health.mjs";
import { CurvatureService } from "./protocol.mjs";
import { curvatureRequest, normalsRequest } from "./requests.mjs";
import { callWithRetries } from "./retries.mjs";
import { callMetadata, connectionTo } from "./security.mjs";

const CHANNEL_OPTIONS = {
  // A peer that died without a word is found within 30 s. On a slow line the question waits behind points that are on
  // their way, for some seconds.
  "grpc.keepalive_time_ms": 10_000,
  "grpc.keepalive_timeout_ms": 20_000,
  // One that came back is found by the next try.
  "grpc.initial_reconnect_backoff_ms": 250,
  "grpc.max_reconnect_backoff_ms": 2_000,
  "grpc.max_receive_message_length": 256 << 20,
  // A name with several addresses stands for replicas, which calls go to in turn.
  "grpc.service_config": JSON.stringify({ loadBalancingConfig: [{ round_robin: {} }] }),
};

// Calls one server, or several replicas, over connections that it keeps until close. They do not keep a process alive.
export class CurvatureClient {
  #services;
  #metadata;
  #turn;
  #reached = false;
  #closing = new AbortController();

  // server, and of the options security and credentials: as estimateCurvature has them. Throws a TypeError if they make
  // no connection.
  constructor(server = DEFAULT_SERVER, options = {}) {
    checkConnectionOptions({ ...options, server });
    const targets = splitServers(server);
    this.#metadata = callMetadata(options.security);
    const connections = targets.map((target) => connectionTo(target, options.security));
    this.#services = targets.map((target, i) => {
      const credentials = options.credentials ?? connections[i].credentials;
      return new CurvatureService(target, credentials, { ...CHANNEL_OPTIONS, ...connections[i].options });
    });
    setMaxListeners(0, this.#closing.signal); // one for each call that runs
    this.#turn = Math.floor(Math.random() * targets.length);
  }

  // As the function estimateCurvature, without the options of connections.
  async estimateCurvature(positions, normals, options = {}) {
    return this.#estimate(curvatureRequest(positions, normals, options), options);
  }

  // As estimateCurvature, for results that are not to lie in memory all at once, or are wanted as they come: an object to
  // iterate over with `for await`, which gives { firstIndex, pointCount, status, meanCurvature, ... }, the arrays of some
  // thousand points each, in the order of the points. Once all have come, its `summary` is there; before it is null.
  //
  // Each iteration is a call. Results are read as they are taken: while nobody takes any, the server is held up, and ends
  // the call after its --stall-timeout: CANCELLED here, STALLED in its log. Leaving the loop cancels the call. A call is
  // tried again until its first results have come; what fails afterwards ends the iteration with a CurvdError. Throws a
  // TypeError at once if the arguments make no request.
  estimateChunks(positions, normals, options = {}) {
    const request = curvatureRequest(positions, normals, options);
    const iterate = (done) => this.#iterate(request, options, done);
    return {
      summary: null,
      [Symbol.asyncIterator]() {
        return iterate((summary) => (this.summary = summary));
      },
    };
  }

  // As the function estimateNormals, without the options of connections.
  async estimateNormals(positions, normals = null, options = {}) {
    return this.#estimate(normalsRequest(positions, normals, options), options);
  }

  // Resolves to the contract's GetServerInfoResponse, with estimators by the names that calls take: what the server is and
  // accepts. Options: timeoutMs, maxAttempts,
  // connectTimeoutMs and signal, as estimateCurvature has them. Rejects with a CurvdError.
  async info(options = {}) {
    const info = await this.#ask((service, ...call) => service.getServerInfo({}, ...call), options);
    return { ...info, estimators: estimatorNames(info.estimators) };
  }

  // Resolves to "SERVING", to "NOT_SERVING" where the server drains, or to another word of grpc.health.v1. Needs no token.
  // Options and errors as info has them.
  async health(options = {}) {
    return this.#ask(checkHealth, options);
  }

  // Ends the calls that run: they reject. Closes the connections. May be called again.
  close() {
    this.#closing.abort(new Error("the client is closed"));
    this.#services.forEach((service) => service.close());
  }

  async #estimate(request, options) {
    const estimate = await this.#withRetries(options, (service, timeoutMs, signal) =>
      callOnce(service, request, { timeoutMs, signal, metadata: this.#metadata }),
    );
    emitWarnings(estimate.summary);
    return estimate;
  }

  async *#iterate(request, options, done) {
    const stop = this.#stopOf(options.signal);
    let chunks;
    try {
      // Which try it was is known with its first chunk.
      let step = await this.#tryReplicas(options, stop.signal, (service, timeoutMs) => {
        chunks = receiveChunks(service, request, { timeoutMs, signal: stop.signal, metadata: this.#metadata });
        return chunks.next();
      });
      for (; !step.done; step = await chunks.next()) yield step.value;
      emitWarnings(step.value);
      done(step.value);
    } finally {
      await chunks?.return();
      stop.release();
    }
  }

  // A call of one message each way: send(service, metadata, options, callback).
  async #ask(send, options) {
    checkCallOptions(options);
    return this.#withRetries(options, (service, timeoutMs, signal) => {
      const deadline = timeoutMs === undefined ? Infinity : Date.now() + timeoutMs;
      return new Promise((resolve, reject) => {
        let answered = false;
        const onAbort = () => {
          call.cancel();
          reject(signal.reason);
        };
        const call = send(service, this.#metadata, { deadline }, (error, response) => {
          signal.removeEventListener("abort", onAbort);
          error === null ? resolve(response) : reject(fromServiceError(error, answered));
        });
        call.once("metadata", () => (answered = true));
        signal.addEventListener("abort", onAbort, { once: true });
      });
    });
  }

  async #withRetries(options, attempt) {
    const stop = this.#stopOf(options.signal);
    try {
      return await this.#tryReplicas(options, stop.signal, (service, timeLeft) => attempt(service, timeLeft, stop.signal));
    } finally {
      stop.release();
    }
  }

  // A signal that ends what runs when the client is closed or the caller's signal says so, until it is released. Throws
  // the reason where one has ended already. AbortSignal.any came later than the oldest Node.js that is served.
  #stopOf(signal) {
    const stop = new AbortController();
    const sources = [this.#closing.signal, ...(signal === undefined ? [] : [signal])];
    const onAbort = (event) => stop.abort(event.target.reason);
    for (const source of sources) if (source.aborted) throw source.reason;
    for (const source of sources) source.addEventListener("abort", onAbort, { once: true });
    const release = () => sources.forEach((source) => source.removeEventListener("abort", onAbort));
    return { signal: stop.signal, release };
  }

  async #tryReplicas({ timeoutMs, maxAttempts = 6, connectTimeoutMs = 1500 }, signal, attempt) {
    try {
      const result = await callWithRetries(this.#services, attempt, {
        first: this.#turn++,
        timeoutMs,
        maxAttempts,
        connectTimeoutMs: this.#reached ? undefined : connectTimeoutMs,
        signal,
      });
      this.#reached = true;
      return result;
    } catch (error) {
      this.#reached ||= error?.answered === true;
      throw error;
    }
  }
}

function emitWarnings({ warnings }) {
  for (const { code, message } of warnings) {
    process.emitWarning(message, { type: "CurvdWarning", code: `CURVD_${String(code).replace(/^WARNING_CODE_/, "")}` });
  }
}
