// Reads where servers are: HOST, HOST:PORT, a gRPC target, or several with commas between.
import { isIPv6 } from "node:net";
import { show } from "./show.mjs";

export const DEFAULT_PORT = 50061;
export const DEFAULT_SERVER = `localhost:${DEFAULT_PORT}`;

// Targets of gRPC. Those of the first kind are themselves lists with commas between.
const LISTS = ["ipv4:", "ipv6:"];
const PATHS = ["unix:", "unix-abstract:"];
// What people paste from a browser, and any other scheme that gRPC would look up as a part of a name.
const URL_OF_OTHERS = /^([a-z][a-z\d+.-]{0,20}):\/\//i;

// The targets of the channels to open, each with a port. Throws a TypeError, naming the part, if one is empty, a
// URL that is no target of gRPC, or has a port that is none. A list with commas between gives one target each; "ipv4:A:1,B:2" is one target, with two addresses.
export function splitServers(server) {
  if (typeof server !== "string") {
    throw new TypeError(`server is ${show(server)}; it must be a string such as "${DEFAULT_SERVER}"`);
  }
  const targets = [];
  for (const part of server.split(",").map((text) => text.trim())) {
    const isBare = !hasScheme(part, [...LISTS, ...PATHS, "dns:"]);
    if (isBare && targets.length > 0 && hasScheme(targets.at(-1), LISTS)) {
      targets[targets.length - 1] += `,${withPort(part)}`;
    } else {
      targets.push(targetOf(part));
    }
  }
  return targets;
}

// Whether all that the target names is this machine, by what is written there alone.
export function isLocal(target) {
  if (hasScheme(target, PATHS)) return true;
  const scheme = LISTS.find((list) => target.startsWith(list));
  const addresses = scheme === undefined ? [target.replace(/^dns:(\/\/\/)?/, "")] : target.slice(scheme.length).split(",");
  return addresses.every((address) => {
    const host = address.slice(0, address.lastIndexOf(":"));
    return host === "localhost" || host === "[::1]" || /^127\.\d{1,3}\.\d{1,3}\.\d{1,3}$/.test(host);
  });
}

function hasScheme(text, schemes) {
  return schemes.some((scheme) => text.startsWith(scheme));
}

function targetOf(text) {
  if (hasScheme(text, PATHS)) return text;
  const scheme = [...LISTS, "dns:"].find((each) => text.startsWith(each)) ?? "";
  if (scheme === "") refuseUrl(text);
  // dns://AUTHORITY/NAME asks a name server of one's own.
  const name = text.slice(text.lastIndexOf("/") + 1).slice(text.includes("/") ? 0 : scheme.length);
  return text.slice(0, text.length - name.length) + withPort(name);
}

function refuseUrl(text) {
  const url = URL_OF_OTHERS.exec(text);
  if (url === null) return;
  const hint = /^(https|grpcs)$/i.test(url[1]) ? ": TLS has an option of its own" : "";
  throw new TypeError(`server ${show(text)} is a URL; it must be HOST or HOST:PORT, as "${DEFAULT_SERVER}", without ${url[0]}${hint}`);
}

function withPort(address) {
  const bare = address.replace(/^\[|\]$/g, "");
  if (isIPv6(bare)) return `[${bare}]:${DEFAULT_PORT}`;
  if (address === "" || address.startsWith(":")) {
    throw new TypeError(`server ${show(address)} names no host; it must be HOST or HOST:PORT, as "${DEFAULT_SERVER}"`);
  }
  const port = /:([^:\]]*)$/.exec(address)?.[1];
  if (port === undefined) return `${address}:${DEFAULT_PORT}`;
  if (!/^\d{1,5}$/.test(port) || Number(port) < 1 || Number(port) > 65535) {
    throw new TypeError(`server ${show(address)} has port ${show(port)}; it must be from 1 to 65535`);
  }
  return address;
}
