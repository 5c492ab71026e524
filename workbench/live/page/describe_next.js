// What is said of the whole: where it goes on, a part that is better split first, and what is doubted.

import { ask } from "./connection.js";
import { at, element, heldFields } from "./elements.js";

export class Next {
  // each: asks something of the bench; say: writes into the status line.
  constructor(each, say) {
    Object.assign(this, { each, say });
  }

  show(head, saves) {
    this.large(head.large);
    at("next").hidden = !head.next.length || head.unsaved;
    at("study-open").hidden = !head.study;
    at("study-open").textContent = `Open ${head.study}`;
    at("study-open").onclick = () => this.open({});
    at("study-new").textContent = head.study ? "Make another first study and open it" : "Make a first study and open it";
    at("study-new").hidden = !saves;
    at("study-new").onclick = () => this.open({ anew: Boolean(head.study) });
    at("next-commands").textContent = head.next.join("\n");
    at("unfinished").replaceChildren(...head.unfinished.map((words) => element("li", words)));
  }

  open(given) {
    const held = heldFields().map((field) => `"${field.value}"`);
    if (held.length) return this.say(`typed and not used: ${held.join(", ")}; use it, or press Esc in its field, and open the study then`, true);
    this.say("the study is being made and opened; the first time this takes a while");
    return ask("study", given);
  }

  // A part that most of the mesh is: what is picked on it would be picked on all of it.
  large(found) {
    at("large").hidden = !found;
    if (!found) return;
    const { name, share, pieces, can } = found;
    const words = `${Math.round(100 * share)} % of the triangles are of ${name}`;
    const count = pieces.toLocaleString("en");
    at("large-words").textContent = can
      ? `${words}, which falls into ${count} connected pieces: split it before anything is picked on it.`
      : `${words}, and it falls into ${count} pieces, too many to be parts: its triangles are not connected. Connect them where the mesh was made.`;
    at("large-split").hidden = !can;
    at("large-split").onclick = () => this.each("split", { part: name });
  }

  // Something that is doubted, and a button that puts it away.
  doubt({ words, about }) {
    const made = element("li", words);
    const away = () => this.each("accept", { about });
    if (about) made.append(" ", element("button", "It is right", { type: "button", className: "small", onclick: away }));
    return made;
  }
}
