// Screw theory drawn, and the numbers behind it.

export class Theory {
  // `page` holds view, panel, state and ask(request).
  constructor(page) {
    this.page = page;
  }
}
