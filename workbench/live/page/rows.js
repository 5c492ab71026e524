// Rows of the tables: verdicts, and what is nearest to what.

import { plain } from "/view/pick.js";
import { element } from "./elements.js";

// A cell whose words look at a place of the picture.
function lookCell(words, point, look) {
  const cell = element("td", point ? "" : words);
  if (point) cell.append(element("button", words, { type: "button", className: "look", onclick: () => look(point, words) }));
  return cell;
}

// A number with so many digits behind the point, with a true minus sign and without one of zero.
export function signed(number, digits = 1) {
  const text = number.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

// A margin: with one digit behind the point, or with as many as it takes not to read as zero.
export function marginWords(number) {
  const digits = [1, 2, 3, 4, 5, 6].find((count) => Number(number.toFixed(count)) !== 0) ?? 1;
  return signed(number, digits);
}

// How much of the overlap of a near pair is allowed, in mm; "" where nothing overlaps.
export function allowedWords({ mm, allowed }) {
  if (mm >= 0) return "";
  return allowed > 0 ? `${signed(allowed)} allowed` : "none allowed";
}

// A near pair, red where it is deeper than it may be; fill: is given it where a distance is to be asked for.
export function nearRow(pair, look, fill) {
  const row = element("tr");
  const target = plain(pair.other ? `${pair.other}: ${pair.target}` : pair.target);
  row.append(
    element("td", signed(pair.mm), { className: `number ${pair.deep ? "failed" : ""}` }),
    element("td", allowedWords(pair), { className: `soft ${pair.deep ? "failed" : ""}` }),
    lookCell(`${pair.person}: ${pair.subject}`, pair.point, look),
    element("td", target),
  );
  const limit = element("td");
  const words = `${pair.person}: ${pair.segment} to ${target}`;
  if (pair.other !== pair.person) {
    const made = element("button", "limit", { type: "button", className: "look", onclick: () => fill(pair) });
    made.setAttribute("aria-label", `ask for a distance of ${words}`);
    limit.append(made);
  }
  row.append(limit);
  return row;
}

const NOW = "from where everybody is now; once all rests, a run may find another place for the seat";

// What a verdict comes to, in words; now: of a state that may still be changed.
export function resultWords({ passed, now }) {
  if (now) return passed ? "✓ passes now" : "✗ FAILS now";
  return passed ? "✓ passed" : "✗ FAILED";
}

// A verdict; look: is given its place, its words and itself; show: the case and the time [s] of one of a motion.
export function verdictRow(verdict, look, show) {
  const row = element("tr");
  const margin = verdict.margin === null ? "" : `${marginWords(verdict.margin)} ${verdict.unit}`;
  const where = verdict.case ? `${verdict.words} (${verdict.case})` : verdict.words;
  const place = lookCell(where, verdict.point, (point, words) => look(point, words, verdict));
  if (verdict.time !== null) {
    const moment = () => {
      if (verdict.point) look(verdict.point, where);
      show(verdict.case, verdict.time);
    };
    place.replaceChildren(element("button", `${where} at ${verdict.time.toFixed(3)} s`, { type: "button", className: "look", onclick: moment }));
  }
  row.append(
    element("td", resultWords(verdict), { className: `short ${verdict.passed ? "passed" : "failed"}`, title: verdict.now ? NOW : "" }),
    element("td", verdict.name),
    element("td", margin, { className: "number" }),
    place,
  );
  return row;
}
