// Choices kept in the browser's storage. A page without storage forgets them.

// The text under `name`; null where there is none. `session`: of this window alone.
export function kept(name, { session = false } = {}) {
  try {
    return (session ? sessionStorage : localStorage).getItem(name);
  } catch {
    return null;
  }
}

export function keep(name, text, { session = false } = {}) {
  try {
    (session ? sessionStorage : localStorage).setItem(name, text);
  } catch {
    // It holds as long as the page.
  }
}
