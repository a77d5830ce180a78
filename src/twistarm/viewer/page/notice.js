// What the process has to say of the arm on show as a whole, until it has something else to say.

import { $ } from "./element.js";
import { tell } from "./words.js";

export class Notice {
  constructor() {
    this.messages = { notice: (message) => this.show(message) };
  }

  show({ words, wrong }) {
    tell($("notice"), words);
    $("notice").hidden = words === "";
    $("notice").classList.toggle("wrong", wrong);
  }
}
