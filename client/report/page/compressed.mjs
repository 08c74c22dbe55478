// Shows what the codec (../laz/) makes of a compressed file, in pages that have one.
import { Points } from "./report_file.mjs";

/** Something is wrong with the file, not with the page or the connection. */
export class FileError extends Error {}

/** Resolves to { report, points } of a report on a compressed file and the file's bytes. `tell(text)` is called with what
 * is going on. Rejects with a FileError that names the file and what is wrong. */
export async function readCompressed(report, bytes, tell) {
  try {
    const made = await globalThis.curvLaz.readLaz(report, bytes, tell);
    return { report: made.report, points: new Points(made.report, made.arrays, made.indices, made.report.shown) };
  } catch (error) {
    throw new FileError(`${report.title} cannot be shown: ${error.message}.`, { cause: error });
  }
}
