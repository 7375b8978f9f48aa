/** Curves as text with commas (RFC 4180): numbers in SI units and full precision. */

export interface Column {
  label: string;
  unit: string;
  time: ArrayLike<number>;
  values: ArrayLike<number>;
}

function cell(text: string): string {
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Return one table of curves over all their instants; missing values are empty cells. */
export function csv(columns: readonly Column[]): string {
  const head = ["time [s]", ...columns.map((c) => `${c.label}${c.unit ? ` [${c.unit}]` : ""}`)];
  const times = [...new Set(columns.flatMap((c) => Array.from(c.time)))].sort((a, b) => a - b);
  const at = columns.map(() => 0);
  const lines = times.map((time) => {
    const cells = columns.map((column, k) => {
      if (at[k] >= column.time.length || column.time[at[k]] !== time) return "";
      // an instant may occur twice, at an event: the last value counts
      while (at[k] + 1 < column.time.length && column.time[at[k] + 1] === time) at[k]++;
      const value = column.values[at[k]++];
      return Number.isFinite(value) ? String(value) : "";
    });
    return [String(time), ...cells].join(",");
  });
  return `${[head.map(cell).join(","), ...lines].join("\r\n")}\r\n`;
}
