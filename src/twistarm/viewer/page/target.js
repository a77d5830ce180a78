// The tool dragged, or told where to be: a target, and inverse kinematics after it.

export class Target {
  // `page` holds view, panel, state and ask(request).
  constructor(page) {
    this.page = page;
  }
}
