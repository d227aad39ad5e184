// Numbers and times in words.
import { significant } from "../format.js";

export function bytes(count) {
  if (count < 1000) return `${count} bytes`;
  const step = count < 1e6 ? ["kB", 1e3] : count < 1e9 ? ["MB", 1e6] : ["GB", 1e9];
  return `${significant(count / step[1], 3)} ${step[0]}`;
}

export function duration(seconds) {
  if (seconds < 180) return `${significant(seconds, 3)} s`;
  if (seconds < 3 * 3600) return `${significant(seconds / 60, 3)} min`;
  if (seconds < 72 * 3600) return `${significant(seconds / 3600, 3)} h`;
  return `${significant(seconds / 86400, 3)} days`;
}

export function spread({ least, largest }, unit) {
  if (least === largest) return `${significant(least, 4)} ${unit}`;
  return `${significant(least, 4)} to ${significant(largest, 4)} ${unit}`;
}

export function count(number, thing) {
  return `${number} ${thing}${number === 1 ? "" : "s"}`;
}

/** What was typed as a number: a comma is a decimal point to many. */
export function number(text) {
  const trimmed = text.trim().replace(",", ".");
  if (trimmed === "") return null;
  const value = Number(trimmed);
  if (!Number.isFinite(value)) throw new Error(`expected a number, found “${text.trim()}”`);
  return value;
}

export const KINDS = [
  ["constant-current", "constant current"],
  ["low-rate", "low rate"],
  ["low-rate-charge", "charge at a low rate"],
  ["pulses", "pulses"],
  ["flight", "flight"],
  ["validation", "validation"],
];
