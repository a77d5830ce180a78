// Recorded poses: a list, and the motion planned through it.

export class Program {
  // `page` holds view, panel, state and ask(request).
  constructor(page) {
    this.page = page;
  }
}
