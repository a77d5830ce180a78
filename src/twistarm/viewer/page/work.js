// What the process says of the arm as a whole, and what it is busy with: a line and a bar for each job.

import { $, element } from "./element.js";
import { report } from "./words.js";

const WORDS = { plan: "planning", reach: "mapping the reach", collision: "preparing collision checks", band: "checking the motion" };

export class Work {
  messages = { work: (message) => this.show(message), notice: (message) => this.notice(message) };

  notice({ words, wrong }) {
    report($("notice"), words);
    $("notice").hidden = words === "";
    $("notice").classList.toggle("wrong", wrong);
  }

  show({ jobs }) {
    const reported = jobs.filter(({ key }) => key !== "scene"); // which has its bar in the header
    $("work").replaceChildren(...reported.flatMap(({ key, share }) => {
      const bar = element("progress");
      Object.assign(bar, { max: 1, value: share });
      bar.setAttribute("aria-label", WORDS[key] ?? key);
      return [element("span", "", WORDS[key] ?? key), bar];
    }));
  }
}
