// Numbers as people type them: what is taken, and what is said of the rest.

/** What is taken. */
export interface NumberLimits {
  min: number;
  max: number;
  /** Whole numbers only. */
  whole?: boolean;
  /** Whether it may stay out. */
  optional?: boolean;
  /** A number that it would take. */
  example: string;
}

/** As programs write numbers: with a point, and perhaps an exponent. */
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/** What is taken, in words. */
export function expected({ min, max, whole, example }: NumberLimits): string {
  const kind = whole ? 'a whole number' : 'a number';
  const point = whole ? '' : ' with a decimal point';
  return `expected ${kind} from ${min} to ${max}${point}, such as ${example}`;
}

/** The number of a text; undefined where it is none, or beyond the limits. */
export function numberOf(text: string, { min, max, whole }: NumberLimits): number | undefined {
  const value = NUMBER.test(text) ? Number(text) : Number.NaN;
  const fits = value >= min && value <= max && (!whole || Number.isSafeInteger(value));
  return fits ? value : undefined;
}
