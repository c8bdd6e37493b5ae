// Numbers as text: units after a narrow no-break space, decimals fixed per field.

const THIN = "\u202f";
const MINUS = "\u2212";

export const withUnit = (value, decimals, unit) => `${number(value, decimals)}${THIN}${unit}`;

export function number(value, decimals) {
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

export const percent = (share) => withUnit(Math.round(share * 100), 0, "%");

export const degrees = (radians) => `${number((radians * 180) / Math.PI, 0)}°`;

/** At most three significant digits: 3.4 bits, 12.3 bits. */
export const seconds = (value) => withUnit(value, value < 10 ? 1 : 0, "s");

/** Whole percents of shares that sum to one, summing to 100 (largest remainders). */
export function percentsOf(shares) {
  const exact = shares.map((share) => Math.max(0, share) * 100);
  const whole = exact.map(Math.floor);
  const missing = Math.round(exact.reduce((a, b) => a + b, 0)) - whole.reduce((a, b) => a + b, 0);
  const order = exact.map((value, i) => [value - whole[i], i]).sort((a, b) => b[0] - a[0]);
  for (const [, i] of order.slice(0, Math.max(0, missing))) whole[i] += 1;
  return whole;
}

/** Time of day of a Unix time in ms, as the clock on the wall shows it. */
export function timeOfDay(unixMs) {
  const date = new Date(unixMs);
  const two = (value) => String(value).padStart(2, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
}

export const capitalized = (word) => word.charAt(0).toUpperCase() + word.slice(1);
