// What is handed on: a stand-alone page, a picture.

export class Share {
  // `page` holds view, panel, state and ask(request).
  constructor(page) {
    this.page = page;
  }
}
