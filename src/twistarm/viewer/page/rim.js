// Light along the contours of what is drawn in the dark theme, and shade in the light one: a part as dark or as bright as
// what lies behind it keeps its edge.

const LIGHT = 0.5; // added where the surface turns away from the eye
const SHADE = -0.22;

const BEND = "float bend = 1.0 - abs(dot(normalize(transformedNormal), normalize(-mvPosition.xyz)));";

export class Rim {
  constructor() {
    this.light = { value: SHADE };
    this.compile = (shader) => {
      shader.uniforms.rimLight = this.light;
      shader.vertexShader = shader.vertexShader
        .replace("void main() {", "varying float vRim;\nvoid main() {")
        .replace("#include <project_vertex>", `#include <project_vertex>\n${BEND}\nvRim = bend * bend * bend;`);
      shader.fragmentShader = shader.fragmentShader
        .replace("void main() {", "uniform float rimLight;\nvarying float vRim;\nvoid main() {")
        .replace("#include <emissivemap_fragment>", "#include <emissivemap_fragment>\ntotalEmissiveRadiance += rimLight * vRim;");
    };
  }

  show(dark) { this.light.value = dark ? LIGHT : SHADE; }

  // All that is drawn below `node`, unless it shines through.
  give(node) {
    node.traverse(({ material }) => {
      if (!material?.isMeshLambertMaterial || !material.depthTest || material.onBeforeCompile === this.compile) return;
      Object.assign(material, { onBeforeCompile: this.compile, needsUpdate: true });
    });
  }
}
