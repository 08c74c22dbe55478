// Splats: discs that blend into a closed surface (Botsch et al. 2005), in two passes. The first draws depth alone,
// moved back by a splat's radius; the second adds up the colors of all splats before that depth, weighted toward their
// centers, and the sum is divided by the weights when it goes to the screen.

export const SPLAT_VERTEX = `
precision highp float;
in vec3 position;
in vec2 direction;
in vec4 traits;
in float value;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 extent;
uniform float largestRadius;
uniform float radiusFactor;
uniform float pixelsPerUnit;
uniform float low;
uniform float high;
uniform vec3 noValue;
uniform sampler2D ramp;
flat out vec3 splatNormal;
flat out vec3 splatColor;
flat out float splatRadius;
flat out float splatWeight;
flat out float splatBack;

vec3 octahedral(vec2 uv) {
  vec3 n = vec3(uv, 1.0 - abs(uv.x) - abs(uv.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  return normalize(n);
}

void main() {
  vec3 place = (position * (65535.0 / 65534.0) - 0.5) * extent;
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
  if (traits.z > 0.5) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  float radius = largestRadius * exp2(-traits.x / 16.0) * radiusFactor;
  splatRadius = max(radius * pixelsPerUnit, 0.9);
  gl_PointSize = 2.0 * splatRadius + 1.0;
  vec3 n = traits.w > 0.5 ? vec3(0.0, 0.0, 1.0) : mat3(viewMatrix) * octahedral(direction);
  // What faces away shows only where nothing faces the viewer: thin parts keep their sides apart.
  splatWeight = n.z < 0.0 ? 0.01 : 1.0;
  splatBack = n.z < 0.0 ? 3.0 : 1.0;
  if (n.z < 0.0) n = -n;
  float light = 0.52 + 0.48 * max(dot(n, normalize(vec3(-0.35, 0.45, 0.82))), 0.0);
  splatNormal = vec3(n.xy, max(n.z, 0.3));
  vec3 color = value > 1e30 ? noValue : texture(ramp, vec2((value - low) / (high - low), 0.5)).rgb;
  splatColor = color * light;
}`;

export const SPLAT_FRAGMENT = `
precision highp float;
flat in vec3 splatNormal;
flat in vec3 splatColor;
flat in float splatRadius;
flat in float splatWeight;
flat in float splatBack;
uniform float depthPerPixel;
uniform float moveBack;
out vec4 color;

void main() {
  vec2 p = (gl_PointCoord - 0.5) * vec2(2.0, -2.0) * (splatRadius + 0.5) / splatRadius;
  float z = -dot(splatNormal.xy, p) / splatNormal.z;
  float d = dot(p, p) + z * z;
  if (dot(p, p) > 1.0 || d > 2.0) discard;
  gl_FragDepth = gl_FragCoord.z + (moveBack * splatBack - z) * splatRadius * depthPerPixel;
  float weight = splatWeight * exp(-4.5 * d);
  color = vec4(splatColor * weight, weight);
}`;

export const SCREEN_VERTEX = `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;

export const SCREEN_FRAGMENT = `
precision highp float;
uniform sampler2D sums;
uniform int samples;
out vec4 color;

void main() {
  vec4 total = vec4(0.0);
  ivec2 corner = ivec2(gl_FragCoord.xy) * samples;
  for (int y = 0; y < samples; y++) {
    for (int x = 0; x < samples; x++) {
      vec4 s = texelFetch(sums, corner + ivec2(x, y), 0);
      if (s.a > 0.0) total += vec4(s.rgb / s.a, 1.0);
    }
  }
  color = total / float(samples * samples);
}`;
