// Numbers of a summary, which may be null where they could not be computed.

export const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

/** A list of a summary, or an empty one where there is none. */
export const listOf = (value) => (Array.isArray(value) ? value : []);

/** The different numbers of a list, rising. */
export const distinct = (values) => [...new Set(values.filter(isNumber))].sort((a, b) => a - b);

/** A number times a factor; null stays null. */
export const times = (factor, value) => (isNumber(value) ? factor * value : null);
