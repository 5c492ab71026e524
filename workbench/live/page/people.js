// The population: which share of it fits, reaches and clears, and who fits now or does no longer.

import { at, element } from "./elements.js";

const percent = (share) => `${(100 * share).toFixed(1)} %`;

// Who a person of the population is, in words.
export function who({ person, sex, stature }) {
  const kind = sex === "female" ? "woman" : "man";
  return `person ${person}, a ${kind}${stature ? ` of ${stature} mm` : ""}`;
}

// A share in words: between which two it lies where not everybody is known.
export function range({ share, most }) {
  if (most - share < 0.0005) return percent(share);
  return `${(100 * share).toFixed(1)} to ${percent(most)}`;
}

// By how much a share has changed at least, in words; "" where it has not, or may not have.
export function change({ share, most, was }) {
  const points = 100 * Math.max(share - was, 0) + 100 * Math.min(most - was, 0);
  if (Math.abs(points) < 0.05) return "";
  return `${points > 0 ? "+" : "−"}${Math.abs(points).toFixed(1)}`;
}

export class People {
  constructor() {
    this.generation = 0;
  }

  // Another state is answered: what is known of the one before is grey until it is followed.
  answered({ generation }) {
    at("people").classList.toggle("waiting", generation !== this.generation);
  }

  show(head) {
    at("people").hidden = false;
    at("people-known").textContent = head.words ? `– ${head.words}` : this.known(head);
    if (head.words) return;
    at("people-numbers").hidden = false;
    this.generation = head.generation;
    at("people").classList.remove("waiting");
    at("people-shares").replaceChildren(...head.shares.map(shareBar));
    this.changes(head);
    const rows = head.rows.filter((row) => row.share < 1 || row.was !== 1);
    at("people-rows").replaceChildren(...rows.map(requirementRow));
  }

  // Another study is open, with these people.
  forget(people) {
    this.elsewhere = people.find((one) => one.many)?.stands ? "from another place" : "in another position of the seat";
    at("people").hidden = true;
    at("people-numbers").hidden = true;
  }

  known({ known, settled, of, asked }) {
    if (known === of && settled === of) return `– all ${of} people`;
    const rest = settled < known ? `, ${known - settled} to be settled` : "";
    return `– ${known} of ${of} people${rest}${asked ? `, ${asked} still being asked` : ""}`;
  }

  changes({ changed }) {
    const now = changed.filter((one) => one.fits).length;
    const words = [];
    if (now) words.push(`${now} fit now`);
    if (changed.length > now) words.push(`${changed.length - now} fit no longer`);
    at("people-changes").textContent = words.join(", ") || "the same people fit as in the study as opened";
    const list = at("people-changed").querySelector("ul");
    list.replaceChildren(...changed.map((one) => element("li", this.changed(one))));
  }

  changed(one) {
    const lead = `${who(one)}, ${one.fits ? "fits now" : "fits no longer"}`;
    const amount = `${one.margin.toFixed(1)}${one.unit}`.replace("-", "−");
    const why = one.fits ? `missed before: ${one.name} (${amount})` : `${one.name} (${amount})`;
    return `${lead}: ${why}${one.settled ? "" : `; perhaps ${this.elsewhere}`}`;
  }
}

function shareBar(one) {
  const { name, share } = one;
  const row = element("div", "", { className: "share" });
  const meter = element("meter", "", { min: 0, max: 1, value: share });
  meter.setAttribute("aria-label", `share who ${name}`);
  const difference = change(one);
  row.append(
    element("span", name),
    meter,
    element("output", range(one), { ariaLive: "off" }),
    element("span", difference, { className: difference.startsWith("−") ? "failed" : "passed" }),
  );
  return row;
}

function requirementRow(one) {
  const { name, most } = one;
  const was = one.was ?? 1;
  const row = element("tr");
  row.append(
    element("td", range(one), { className: `number ${most < was - 1e-9 ? "failed" : ""}` }),
    element("td", one.was === null ? "new" : percent(was), { className: "number" }),
    element("td", name),
  );
  return row;
}
