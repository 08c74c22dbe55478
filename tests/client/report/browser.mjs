// Drives a Chromium without a window, by the Chrome DevTools Protocol over two pipes: no port, no library.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const NAMES = ["chromium", "chromium-browser", "google-chrome"];
// WebGL without a graphics card; as root in a container there is no sandbox.
const FLAGS = [
  "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run",
  "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
  "--disable-background-networking", "--disable-component-update", "--disable-extensions",
];

/** The path of a browser, or null. CURVD_CHROMIUM names another. */
export function findBrowser() {
  if (process.env.CURVD_CHROMIUM) return process.env.CURVD_CHROMIUM;
  for (const folder of (process.env.PATH ?? "").split(":")) {
    for (const name of NAMES) if (existsSync(join(folder, name))) return join(folder, name);
  }
  return null;
}

/** A browser with tabs; close() ends it. */
export class Browser {
  static async start(path) {
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), "curv-report-browser-"));
    browser.process = spawn(path, [...FLAGS, `--user-data-dir=${browser.profile}`, "about:blank"],
                            { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    browser.pending = new Map();
    browser.tabs = new Map();
    browser.lastId = 0;
    browser.ended = new Promise((resolve) => browser.process.once("close", resolve));
    browser.process.once("error", (error) => browser.#failAll(error));
    browser.ended.then(() => browser.#failAll(new Error("the browser ended")));
    browser.#listen();
    return browser;
  }

  #failAll(error) {
    for (const { reject } of this.pending.values()) reject(error);
    this.pending.clear();
  }

  // Messages are JSON, each ended by a zero byte.
  #listen() {
    let pieces = [];
    this.process.stdio[4].on("data", (bytes) => {
      let begin = 0;
      for (let end = bytes.indexOf(0); end >= 0; end = bytes.indexOf(0, begin)) {
        pieces.push(bytes.subarray(begin, end));
        this.#receive(JSON.parse(Buffer.concat(pieces).toString()));
        pieces = [];
        begin = end + 1;
      }
      if (begin < bytes.length) pieces.push(bytes.subarray(begin));
    });
    this.process.stdio[3].on("error", () => {});
  }

  #receive({ id, result, error, method, params, sessionId }) {
    if (id === undefined) return this.tabs.get(sessionId)?.receive(method, params);
    const waiting = this.pending.get(id);
    this.pending.delete(id);
    return error ? waiting?.reject(new Error(error.message)) : waiting?.resolve(result);
  }

  send(method, params = {}, sessionId = undefined) {
    const id = ++this.lastId;
    return new Promise((resolve, reject) => {
      this.pending.set(id, { resolve, reject });
      this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    });
  }

  async openTab(width, height) {
    const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    const tab = new Tab(this, sessionId);
    this.tabs.set(sessionId, tab);
    for (const domain of ["Page", "Runtime", "Network", "Log"]) await tab.send(`${domain}.enable`);
    await tab.resize(width, height);
    return tab;
  }

  async close() {
    this.send("Browser.close").catch(() => {});
    await this.ended;
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

/** One page. `requests` are the addresses that it asked for, `errors` what it said went wrong. */
class Tab {
  constructor(browser, sessionId) {
    Object.assign(this, { browser, sessionId, requests: [], errors: [] });
  }

  receive(method, params) {
    if (method === "Network.requestWillBeSent") this.requests.push(params.request.url);
    if (method === "Runtime.exceptionThrown") {
      const { exception, text } = params.exceptionDetails;
      this.errors.push(exception?.description ?? text);
    }
    if (method === "Log.entryAdded" && params.entry.level === "error") this.errors.push(params.entry.text);
    if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) {
      this.errors.push(params.args.map(({ value, description }) => value ?? description).join(" "));
    }
  }

  send(method, params = {}) {
    return this.browser.send(method, params, this.sessionId);
  }

  async resize(width, height) {
    await this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
  }

  async setScheme(scheme) {
    await this.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
  }

  /** Opens a file, or an address, and waits until `condition`, JavaScript, holds. */
  async open(path, condition, seconds) {
    await this.send("Page.navigate", { url: path.startsWith("http:") ? path : `file://${path}` });
    await this.waitFor(condition, seconds);
  }

  /** The value of an expression in the page. */
  async evaluate(expression) {
    const { result, exceptionDetails } =
      await this.send("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description}`);
    return result.value;
  }

  /** Looks again at every picture that the page draws, until the condition holds. */
  async waitFor(condition, seconds = 30) {
    const held = await this.evaluate(`new Promise((resolve) => {
      const deadline = performance.now() + ${seconds * 1000};
      const look = () => {
        let holds = false;
        try { holds = Boolean(${condition}); } catch {}
        if (holds || performance.now() > deadline) resolve(holds);
        else requestAnimationFrame(look);
      };
      look();
    })`);
    if (!held) throw new Error(`after ${seconds} s it still does not hold: ${condition}`);
  }

  /** The bytes of a PNG of the window, or of the box of the element. */
  async screenshot(selector) {
    const clip = selector && await this.evaluate(`(() => {
      const { x, y, width, height } = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect();
      return { x: x + scrollX, y: y + scrollY, width, height, scale: 1 };
    })()`);
    const { data } = await this.send("Page.captureScreenshot", { format: "png", ...(clip ? { clip } : {}) });
    return Buffer.from(data, "base64");
  }

  async mouse(type, x, y, more = {}) {
    const buttons = type === "mouseReleased" ? 0 : 1;
    await this.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons, clickCount: 1, ...more });
  }

  async click(x, y) {
    await this.mouse("mouseMoved", x, y, { button: "none", buttons: 0 });
    await this.mouse("mousePressed", x, y);
    await this.mouse("mouseReleased", x, y);
  }

  async press(key, text) {
    await this.send("Input.dispatchKeyEvent", { type: text ? "keyDown" : "rawKeyDown", key, code: key, text });
    await this.send("Input.dispatchKeyEvent", { type: "keyUp", key, code: key });
  }
}
