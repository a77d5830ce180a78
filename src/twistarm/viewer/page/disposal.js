// What the graphics card holds of a drawing is given back by hand.

// Take everything out of `group`; what it draws is used nowhere else.
export function dispose(group) {
  group.traverse(({ geometry, material }) => {
    geometry?.dispose();
    material?.map?.dispose();
    material?.alphaMap?.dispose();
    material?.dispose();
  });
  group.clear();
}
