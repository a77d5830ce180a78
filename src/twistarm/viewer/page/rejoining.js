// What a page does where another run of the program answers at its address: it lives on, with the layers that it showed.

export class Rejoining {
  // `page` holds ask(request).
  constructor({ ask }) {
    this.ask = ask;
    this.messages = { visible: ({ type, ...layers }) => this.show(layers) };
  }

  // `code` of another version is not this page's: it begins anew.
  hello({ code, run }) {
    if (this.code !== undefined && code !== this.code) return location.reload();
    this.before = this.run !== undefined && run !== this.run ? this.layers : {};
    this.code = code;
    this.run = run;
  }

  show(layers) {
    const before = this.before;
    this.layers = layers;
    this.before = {};
    for (const [what, visible] of Object.entries(before)) {
      if (what in layers && layers[what] !== visible) this.ask({ type: "visible", what, visible });
    }
  }
}
