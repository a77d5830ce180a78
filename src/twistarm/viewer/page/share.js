// What is handed on: the stand-alone page, and a picture of the view.

import { $ } from "./element.js";
import { closable } from "./menu.js";
import { stateOf } from "./page_state.js";
import { asBlob, painted } from "./picture.js";
import { fileName, save } from "./saving.js";
import { keep, kept } from "./storage.js";

const SIDES = ["width", "height"];
const SMALLEST = 16; // pixels
const LARGEST = 8192;
const KEPT = "twistarm picture"; // width and height as typed, with a comma between them

const STATE = 'id="state">{}'; // where export.py leaves room for it, ahead of all scripts

export class Share {
  // `page` holds the view and, where the page can be saved, keepers().
  constructor(page) {
    this.page = page;
    this.view = page.view;
    this.name = "";
    const typed = (kept(KEPT) ?? ",").split(",");
    SIDES.forEach((side, i) => {
      $(`picture-${side}`).value = typed[i];
      $(`picture-${side}`).addEventListener("keydown", ({ key }) => key === "Enter" && this.act(() => this.picture()));
    });
    $("save-page")?.addEventListener("click", () => this.act(() => this.standAlone()));
    $("save-picture").addEventListener("click", () => this.act(() => this.picture()));
    $("share").addEventListener("toggle", () => this.open());
    closable($("share"));
  }

  hello({ arm }) {
    this.name = arm.name;
  }

  open() {
    this.say("");
    SIDES.forEach((side, i) => { $(`picture-${side}`).placeholder = this.size()[i]; });
  }

  // Do one thing at a time, and say what came of it.
  async act(make) {
    if (this.busy) return;
    this.busy = true;
    this.say("making it …");
    await new Promise((resolve) => setTimeout(resolve)); // so that it is read
    try {
      this.say(`saved: ${await make()}`);
    } catch (error) {
      this.say(error.message, true);
    } finally {
      this.busy = false;
    }
  }

  async standAlone() {
    let answer;
    try {
      answer = await fetch("arm.html");
    } catch {
      throw new Error("the process does not answer; is it still running?");
    }
    if (!answer.ok) throw new Error((await answer.text()).trim());
    const page = await answer.text();
    // A "<" in JSON can only stand in a string; escaped, no name can close the script.
    const state = JSON.stringify(stateOf(this.page.keepers())).replaceAll("<", "\\u003c");
    const [head, tail] = halves(page, STATE);
    return saved(new Blob([head, STATE.slice(0, -2), state, tail], { type: "text/html" }), fileName(this.name, ".html"));
  }

  async picture() {
    const typed = SIDES.map((side) => $(`picture-${side}`).value.trim());
    const sides = typed.map((text, i) => pixels(text || String(this.size()[i]), SIDES[i]));
    keep(KEPT, typed.join());
    return saved(await asBlob(painted(this.view, ...sides)), fileName(this.name, ".png"));
  }

  // Of the view, in pixels: what an empty box means.
  size() {
    const { offsetWidth, offsetHeight } = $("pane");
    return [offsetWidth, offsetHeight];
  }

  say(text, wrong = false) {
    $("share-said").textContent = text;
    $("share-said").classList.toggle("wrong", wrong);
  }
}

function saved(blob, name) {
  save(blob, name);
  return name;
}

// What stands before and after the first `mark` in a text.
function halves(text, mark) {
  const at = text.indexOf(mark);
  return [text.slice(0, at), text.slice(at + mark.length)];
}

function pixels(text, side) {
  const number = Number(text);
  if (/^\d+$/.test(text) && number >= SMALLEST && number <= LARGEST) return number;
  throw new Error(`the ${side} is a whole number of pixels, ${SMALLEST} … ${LARGEST}; got ${text.slice(0, 20)}`);
}
