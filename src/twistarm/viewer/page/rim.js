// Light along the contours of what is drawn, in the dark theme: a part as dark as what lies behind it keeps its edge.

const STRENGTH = 0.5; // of the light where the surface turns away from the eye
const NONE = 0;

const BEND = "float bend = 1.0 - abs(dot(normalize(transformedNormal), normalize(-mvPosition.xyz)));";

export class Rim {
  constructor() {
    this.light = { value: NONE };
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

  show(dark) {
    this.light.value = dark ? STRENGTH : NONE;
  }

  // All that is drawn below `node`, unless it shines through.
  give(node) {
    node.traverse(({ material }) => {
      if (!material?.isMeshLambertMaterial || !material.depthTest || material.onBeforeCompile === this.compile) return;
      Object.assign(material, { onBeforeCompile: this.compile, needsUpdate: true });
    });
  }
}
