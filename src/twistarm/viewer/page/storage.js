// Choices kept in the browser's storage: of a window's session for one address. A page without storage forgets them.

// The text under `name`; null where there is none. `session`: of this window alone.
export function kept(name, { session = false } = {}) {
  try {
    return session ? sessionStorage.getItem(here(name)) : localStorage.getItem(name);
  } catch {
    return null;
  }
}

export function keep(name, text, { session = false } = {}) {
  try {
    if (session) sessionStorage.setItem(here(name), text);
    else localStorage.setItem(name, text);
  } catch {
    // It holds as long as the page.
  }
}

// The saved pages of a folder share one storage. A live page has another address at each start.
const here = (name) => document.getElementById("data") ? `${name} ${location.pathname}` : name;
