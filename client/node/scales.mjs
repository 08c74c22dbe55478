// Results of a call with several neighbor counts: those of the first for all points, then those of the next.

// Hands each ResultChunk to the collector, or reader, of its neighbor count, which `make()` makes. Without counts there is
// one, of chunks that tell none.
export class Scales {
  #counts;
  #collectors;
  #current = 0;

  constructor(counts, make) {
    this.#counts = counts.length === 0 ? [0] : counts;
    this.#collectors = this.#counts.map(make);
  }

  // Throws, saying what is wrong, if the chunk is not of the count whose results are next.
  of({ neighborCount }) {
    const isLast = this.#current + 1 === this.#counts.length;
    if (this.#collectors[this.#current].isComplete && !isLast) ++this.#current;
    if (neighborCount !== this.#counts[this.#current]) {
      throw new Error(`results of ${neighborCount} neighbors came, not of ${this.#counts[this.#current]}`);
    }
    return this.#collectors[this.#current];
  }

  // Checks that every point has its result at each scale.
  finish(summary) {
    for (const collector of this.#collectors) collector.finish(summary);
  }

  // The arrays of the one collector, or those of each under the name `scales`.
  get results() {
    if (this.#counts[0] === 0) return this.#collectors[0].arrays;
    return { scales: this.#collectors.map(({ arrays }, i) => ({ neighborCount: this.#counts[i], ...arrays })) };
  }
}
