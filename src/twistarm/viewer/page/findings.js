// The doctor's findings, gravest first; the chosen one is pointed at in the view.

import { $, element } from "./element.js";
import { report } from "./words.js";

const TAKEN = "several-tips"; // the finding that says which link was taken as the tool, where nobody said
const SEVERITIES = { error: ["error", "errors"], warning: ["warning", "warnings"], info: ["info", "info"] }; // one, several

export class Findings {
  // `point(node, name)` makes a node of the scene stand out; point(null) takes that back.
  constructor(point) {
    this.point = point;
    this.chosen = null; // a finding's key
    this.buttons = new Map();
    $("tip-reason").addEventListener("click", () => this.explain());
    addEventListener("keydown", ({ key }) => {
      if (key === "Escape") this.choose(null);
    });
  }

  // Sent again when the doctor has looked: what is chosen stays so if it is still there.
  show({ findings, counts, note }) {
    this.buttons.clear();
    $("findings").hidden = findings.length === 0 && note === "";
    $("findings-count").replaceChildren(...counted(counts));
    report($("findings-note"), note);
    $("findings-list").replaceChildren(...findings.map((finding) => this.item(finding)));
    this.tipFinding = findings.find(({ code }) => code === TAKEN);
    $("tip-reason").hidden = !this.tipFinding;
    $("tip-reason").title = this.tipFinding?.what ?? "";
    if (this.buttons.has(this.chosen)) this.mark();
    else this.choose(null);
  }

  item(finding) {
    const item = element("li", finding.severity);
    const box = element(finding.node ? "button" : "div", "finding");
    const head = element("span", "head");
    head.append(element("span", "severity", finding.severity), element("code", "", finding.code));
    box.append(head, element("span", "place", finding.place), element("span", "what", finding.what));
    if (finding.remedy) box.append(element("span", "remedy", `→ ${finding.remedy}`));
    if (finding.node) this.choosable(box, finding);
    else box.append(element("span", "nowhere", "Concerns the whole arm."));
    item.append(box);
    return item;
  }

  choosable(button, finding) {
    const key = JSON.stringify(finding);
    button.type = "button";
    button.title = `Show ${finding.name} in the view; Escape removes the mark`;
    button.addEventListener("click", () => this.choose(this.chosen === key ? null : key, finding));
    this.buttons.set(key, button);
  }

  explain() {
    const key = JSON.stringify(this.tipFinding);
    $("findings").open = true;
    this.choose(key, this.tipFinding);
    this.buttons.get(key).scrollIntoView({ block: "nearest" });
  }

  choose(key, finding) {
    if (key === null && this.chosen === null) return;
    this.chosen = key;
    this.mark();
    if (key === null) this.point(null);
    else this.point(finding.node, finding.name);
  }

  mark() {
    for (const [key, button] of this.buttons) button.setAttribute("aria-pressed", key === this.chosen);
  }
}

function counted(counts) {
  const parts = Object.entries(SEVERITIES).filter(([severity]) => counts[severity])
    .map(([severity, [singular, plural]]) => element("span", severity, `${counts[severity]} ${counts[severity] > 1 ? plural : singular}`));
  return parts.length === 0 ? ["none"] : parts.flatMap((part, i) => (i === 0 ? [part] : [", ", part]));
}
