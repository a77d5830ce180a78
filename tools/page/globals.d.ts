// What meshcat.js, loaded before the page's modules, leaves to them.

declare const MeshCat: {
  THREE: typeof import("three");
  Viewer: new (element: HTMLElement) => any;
};
