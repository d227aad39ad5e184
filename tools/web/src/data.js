// What the program put into the page: results, each with its summary (as --summary writes it) and
// the series of samples that its charts need.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  return bytes.buffer;
}

function columnOf({ name, type, data }) {
  const buffer = bytesOf(data);
  const values = type === "f64" ? new Float64Array(buffer) : new Float32Array(buffer);
  return { name, values };
}

/** The series of a result, columns by name as typed arrays: series.column.voltage_V. */
function seriesOf(series) {
  const column = {};
  for (const packed of series.columns) {
    const { name, values } = columnOf(packed);
    column[name] = values;
  }
  return { ...series, column };
}

/** What the page holds: {results, program: {version, commit, written}}. */
export function resultsOf(text) {
  const page = JSON.parse(text);
  const results = page.results.map((result) => ({ ...result, series: result.series.map(seriesOf) }));
  return { results, program: page.program };
}
