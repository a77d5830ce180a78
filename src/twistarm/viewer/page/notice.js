// What the process has to say of the arm on show as a whole, until it has something else to say.

import { $ } from "./element.js";
import { report } from "./words.js";

export class Notice {
  constructor() {
    this.messages = { notice: (message) => this.show(message) };
  }

  show({ words, wrong }) {
    report($("notice"), words);
    $("notice").hidden = words === "";
    $("notice").classList.toggle("wrong", wrong);
  }
}
