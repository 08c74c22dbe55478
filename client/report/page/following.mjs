// Follows what `curv view` serves: the report, its points as they come, and, while it watches a file, the next report.
import { FileError, readCompressed } from "./compressed.mjs";
import { receivePoints } from "./report_file.mjs";

const LOOK_MS = 400;

const find = (id) => document.getElementById(id);
const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
const address = (name) => `${location.pathname}/${name}`;

async function ask(name) {
  const response = await fetch(address(name), { cache: "no-store" });
  if (!response.ok) throw new Error(`curv view answers ${response.status}`);
  return response.json();
}

/** Receives a compressed file, and shows it. */
async function showCompressed(page, report, place, tell) {
  const response = await fetch(place, { cache: "no-store" });
  if (!response.ok) throw new Error(`curv view answers ${response.status}`);
  const made = await readCompressed(report, new Uint8Array(await response.arrayBuffer()), tell);
  tell("");
  page.show(made.report, made.points);
}

/** Shows the present report; `page` is asked to show its first points, then to grow. */
async function showPresent(page, { tell, fail }) {
  for (;;) {
    const report = await ask("report");
    if (report.waiting) {
      find("progress").textContent = `Waiting for ${report.waiting} …`;
      return report;
    }
    let isShown = false;
    const place = address(`points/${report.generation}`);
    try {
      if (report.laz) {
        await showCompressed(page, report, place, tell);
        return report;
      }
      await receivePoints(report, place, (points) => {
        if (isShown) page.grow();
        else page.show(report, points);
        isShown = true;
      });
      return report;
    } catch (error) {
      // The next report takes the place of one whose points are on their way.
      if ((await ask("generation")) !== report.generation) continue;
      if (!(error instanceof FileError)) throw error;
      // The page keeps the version before, if there was one, and the next may be good.
      fail(error.message);
      return report;
    }
  }
}

/** Shows what is served until it ends. `progress` says what goes on, `tell(message)`, or that something fails,
 * `fail(message)`. */
export async function follow(page, progress) {
  const { fail } = progress;
  try {
    let report = await showPresent(page, progress);
    if (page.failure) fail(page.failure);
    while (report.watches) {
      await pause(LOOK_MS);
      if ((await ask("generation")) !== report.generation) report = await showPresent(page, progress);
    }
  } catch (error) {
    fail(`Nothing more comes from curv view: ${error.message}`);
  }
}
