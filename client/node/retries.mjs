// Tries a call again, on another replica where there is one, while that may help.
import { setTimeout as sleep } from "node:timers/promises";

const FIRST_PAUSE_MS = 250;
const DOUBLINGS = 5;

// Resolves to what attempt(target, timeoutMs) of the first try that succeeds resolves to.
//   targets      replicas, each call starting with any of them and going on to the next
//   timeoutMs    for all tries together, undefined: no limit; each try is told what is left
//   maxAttempts  tries at most
// Rejects with the last error when it is not transient, after maxAttempts, or when no time is left for another try.
export async function callWithRetries(targets, attempt, { timeoutMs, maxAttempts }) {
  const start = performance.now();
  const timeLeft = () => (timeoutMs === undefined ? undefined : Math.max(0, timeoutMs - (performance.now() - start)));
  const first = Math.floor(Math.random() * targets.length);
  for (let number = 1; ; ++number) {
    try {
      return await attempt(targets[(first + number - 1) % targets.length], timeLeft());
    } catch (error) {
      const pause = pauseAfter(number, 1000 * (error.retryAfter ?? 0), targets.length > 1);
      if (!error.transient || number >= maxAttempts || pause >= (timeLeft() ?? Infinity)) throw error;
      await sleep(pause);
    }
  }
}

// At once on another replica, then doubling, up to a quarter less so that clients do not come in step.
function pauseAfter(number, asked, another) {
  if (number === 1 && another) return asked;
  return Math.max(asked, (0.75 + 0.25 * Math.random()) * FIRST_PAUSE_MS * 2 ** Math.min(number - 1, DOUBLINGS));
}
