// Names where there is little room.

// Cut in the middle where it has more letters than this: names differ more often in their ends.
export function cut(name, longest) {
  if (name.length <= longest) return name;
  const half = Math.floor(longest / 2);
  return `${name.slice(0, longest - half)}…${name.slice(1 - half)}`;
}
