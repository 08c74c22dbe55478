// Tries a call again, on another replica where there is one, while that may help.
import { setTimeout as sleep } from "node:timers/promises";
import { CurvdError } from "./errors.mjs";

const FIRST_PAUSE_MS = 250;
const DOUBLINGS = 5;
// A century. gRPC ends the process with an error that nobody can catch where a deadline is too far for its clock.
const MOST_TIMEOUT_MS = 100 * 365 * 86_400_000;

// What the caller's own function threw: whatever it is, no try mends it.
export class CallersError {
  constructor(error) {
    this.error = error;
  }
}

// Resolves to what attempt(target, timeoutMs) of the first try that succeeds resolves to.
//   targets      replicas, of which the first try takes number `first` modulo their number, and each other try the next
//   timeoutMs    for all tries together, undefined or centuries: no limit; each try is told what is left
//   maxAttempts  tries at most
//   connectTimeoutMs  after which it gives up if no server has answered and each was tried; undefined: if one has before
//   signal       ends the pauses
// Rejects with the last error when it is not transient, after maxAttempts, or when no time is left for another try; with
// the signal's reason when that ends it.
export async function callWithRetries(targets, attempt, { first, timeoutMs, maxAttempts, connectTimeoutMs, signal }) {
  const start = performance.now();
  const hasLimit = timeoutMs !== undefined && timeoutMs <= MOST_TIMEOUT_MS;
  const timeLeft = () => (hasLimit ? Math.max(0, timeoutMs - (performance.now() - start)) : undefined);
  let connectLeft = () => (connectTimeoutMs ?? Infinity) - (performance.now() - start);
  for (let number = 1; ; ++number) {
    try {
      return await attempt(targets[(first + number - 1) % targets.length], timeLeft());
    } catch (error) {
      if (error instanceof CallersError) throw error.error;
      // A signal's reason: anything, null included.
      if (!(error instanceof CurvdError)) throw error;
      if (error.answered) connectLeft = () => Infinity;
      const pause = pauseAfter(number, 1000 * (error.retryAfter ?? 0), targets.length > 1);
      // Another server has its turn, however long the first kept silent.
      const goesOn = number < targets.length;
      const isOver = pause >= Math.min(timeLeft() ?? Infinity, goesOn ? Infinity : connectLeft());
      if (!error.transient || number >= maxAttempts || isOver) throw error;
      await sleep(pause, undefined, { signal }).catch(() => {
        throw signal.reason;
      });
    }
  }
}

// At once on another replica, then doubling, up to a quarter less so that clients do not come in step.
function pauseAfter(number, asked, another) {
  if (number === 1 && another) return asked;
  return Math.max(asked, (0.75 + 0.25 * Math.random()) * FIRST_PAUSE_MS * 2 ** Math.min(number - 1, DOUBLINGS));
}
