// Follows what `curv view` serves: the report, its points as they come, and, while it watches a file, the next report.
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

/** Shows the present report; `page` is asked to show its first points, then to grow. */
async function showPresent(page) {
  for (;;) {
    const report = await ask("report");
    if (report.waiting) {
      find("progress").textContent = `Waiting for ${report.waiting} …`;
      return report;
    }
    let isShown = false;
    try {
      await receivePoints(report, address(`points/${report.generation}`), (points) => {
        if (isShown) page.grow();
        else page.show(report, points);
        isShown = true;
      });
      return report;
    } catch (error) {
      // The next report takes the place of one whose points are on their way.
      if ((await ask("generation")) === report.generation) throw error;
    }
  }
}

/** Shows what is served until it ends; says `fail(message)` if it cannot. */
export async function follow(page, fail) {
  try {
    let report = await showPresent(page);
    if (page.failure) fail(page.failure);
    while (report.watches) {
      await pause(LOOK_MS);
      if ((await ask("generation")) !== report.generation) report = await showPresent(page);
    }
  } catch (error) {
    fail(`Nothing more comes from curv view: ${error.message}`);
  }
}
