// Shared by the measurements.

const sorted = (values) => [...values].sort((a, b) => a - b);

/** A quantile of numbers, 0 … 1. */
export const quantile = (values, q) => sorted(values)[Math.min(values.length - 1, Math.floor(q * values.length))];

export const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });
