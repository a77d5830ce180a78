// Without a graphics card a picture takes a quarter of a second, and the arm would follow the hand in jerks.

const SOFTWARE = /SwiftShader|llvmpipe|Software|Basic Render/i;
const MOST_PIXELS = 0.75; // for each of the page's

// Fewer pixels and no shadows where the processor draws: 2.4 times as many pictures. What is saved as PNG has both.
export function easeSoftware({ viewer, sun }) {
  const { renderer } = viewer;
  const gl = renderer.getContext();
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  if (!SOFTWARE.test(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER))) return;
  renderer.setPixelRatio(Math.min(devicePixelRatio, MOST_PIXELS));
  const render = viewer.render;
  viewer.render = () => {
    sun.castShadow = false;
    render();
    sun.castShadow = true;
  };
}
