// `lipoid poles`: root locus against the voltage (Figs 6.12, 6.14, 6.16 and 6.19 of the thesis).
import { facts } from "../dom.js";
import { significant } from "../format.js";
import { rootLocus } from "../root_locus.js";

export const poles = {
  command: "poles",
  title: ({ summary }) => `Poles of the ${summary.loop} loop with gains ${summary.gains}`,
  parts: ({ summary }) => {
    const { proportional, integral, derivative } = summary.error_gains ?? {};
    return [
      facts([
        ["Vehicle", summary.vehicle],
        ["Gains", summary.gains],
        ["K_e / (1/s²)", significant(proportional)],
        ["K_eI / (1/s³)", significant(integral)],
        ["K_edot / (1/s)", significant(derivative)],
      ]),
      ...rootLocus(summary.rows, `the ${summary.loop} loop`),
    ];
  },
};
