// A menu of the page: a details element that Escape or a press elsewhere closes.

export function closable(menu) {
  const close = () => { menu.open = false; };
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !menu.open) return;
    close();
    menu.querySelector("summary").focus();
    event.stopPropagation();
  });
  addEventListener("pointerdown", ({ target }) => menu.contains(target) || close(), true);
}
