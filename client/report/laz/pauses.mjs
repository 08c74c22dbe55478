// Lets the browser draw and answer while there is a lot to compute.

const SLICE_MS = 40;

/** Returns a function to await now and then: when enough time has passed since the last pause, it calls `before`, pauses,
 * and goes on once the browser has had its turn. */
export function pauses() {
  let last = performance.now();
  return async (before = () => {}) => {
    if (performance.now() - last < SLICE_MS) return;
    before();
    await new Promise((done) => {
      // Unlike timers, messages are not put off in pages that nobody looks at.
      const channel = new MessageChannel();
      channel.port1.onmessage = () => {
        channel.port1.close();
        done();
      };
      channel.port2.postMessage(null);
    });
    last = performance.now();
  };
}
