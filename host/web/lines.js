// Lines in three dimensions that are some pixels wide, which WebGL alone does not draw.

import { THREE } from "nicegui-scene";

// Each segment is a rectangle on the screen with room for round ends; the fragment shader cuts
// them out and smooths the edge. A segment is cut off just before the eye first.
const VERTEX = `
attribute vec2 corner;
attribute vec3 begin;
attribute vec3 finish;
uniform vec2 screen;
uniform float thickness;
uniform float lift;
varying vec2 place;
varying float span;

void main() {
  // Towards the eye, so that the line is before the ground that it lies on.
  vec4 a = modelViewMatrix * vec4(begin, 1.0);
  vec4 b = modelViewMatrix * vec4(finish, 1.0);
  a.xyz *= 1.0 - lift;
  b.xyz *= 1.0 - lift;
  float near = -0.002;
  if (a.z > near && b.z < near) a = mix(a, b, (near - a.z) / (b.z - a.z));
  if (b.z > near && a.z < near) b = mix(b, a, (near - b.z) / (a.z - b.z));
  vec4 p = projectionMatrix * a;
  vec4 q = projectionMatrix * b;
  vec2 way = (q.xy / q.w - p.xy / p.w) * screen * 0.5;
  span = length(way);
  vec2 along = span > 0.0 ? way / span : vec2(1.0, 0.0);
  float reach = thickness * 0.5 + 1.0;
  vec2 aside = vec2(-along.y, along.x) * corner.y + along * (corner.x * 2.0 - 1.0);
  place = vec2(mix(-reach, span + reach, corner.x), corner.y * reach);
  gl_Position = corner.x < 0.5 ? p : q;
  gl_Position.xy += aside * reach / (screen * 0.5) * gl_Position.w;
}`;
const FRAGMENT = `
uniform vec3 colour;
uniform float opacity;
uniform float thickness;
varying vec2 place;
varying float span;

void main() {
  float beyond = max(max(-place.x, place.x - span), 0.0);
  // Round ends of a translucent line would show where they overlap.
  if (opacity < 0.8 && beyond > 0.0) discard;
  float cover = clamp(thickness * 0.5 + 0.5 - length(vec2(beyond, place.y)), 0.0, 1.0);
  if (cover < 0.05) discard;
  gl_FragColor = vec4(colour, opacity * cover);
  #include <colorspace_fragment>
}`;

/**
 * Return a mesh of the line through points.
 *
 * @param {number[]} points x, y, z of two points or more, in the scene's units.
 * @param {object} style `colour` (CSS), `width` (pixels), `opacity`, `lift` (towards the eye, as
 *     a share of the distance), `hidden` (true draws it through all that is before it).
 * @param {THREE.Vector2} screen Width and height of the view in pixels, kept up to date by it.
 */
export function fatLine(points, style, screen) {
  const geometry = new THREE.InstancedBufferGeometry();
  const corners = new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]);
  geometry.setAttribute("corner", new THREE.BufferAttribute(corners, 2));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  const all = new THREE.InstancedInterleavedBuffer(new Float32Array(points), 3);
  geometry.setAttribute("begin", new THREE.InterleavedBufferAttribute(all, 3, 0));
  const rest = new THREE.InstancedInterleavedBuffer(new Float32Array(points.slice(3)), 3);
  geometry.setAttribute("finish", new THREE.InterleavedBufferAttribute(rest, 3, 0));
  geometry.instanceCount = points.length / 3 - 1;
  const material = new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      screen: { value: screen },
      colour: { value: new THREE.Color(style.colour) },
      thickness: { value: style.width },
      opacity: { value: style.opacity ?? 1 },
      lift: { value: style.lift ?? 0 },
    },
    transparent: true,
    depthTest: !style.hidden,
    // Smooth edges would hide the lines after them.
    depthWrite: false,
    side: THREE.DoubleSide,
  });
  const mesh = new THREE.Mesh(geometry, material);
  // The box of the base rectangle says nothing about where the line is.
  mesh.frustumCulled = false;
  return mesh;
}
