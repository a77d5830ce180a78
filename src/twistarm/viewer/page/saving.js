// A file that the browser saves where it saves all it is given.

const LONGEST = 50; // characters of a name, whatever script it is in

export function save(blob, name) {
  const link = document.createElement("a");
  Object.assign(link, { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000); // the browser may still be asking where to
  return name;
}

export function fileName(name, ending) {
  const plain = name.replace(/[^\p{L}\p{N}._-]/gu, "_").replace(/^\.+/, "_");
  return ([...plain].slice(0, LONGEST).join("") || "arm") + ending;
}
