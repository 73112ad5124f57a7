#include "rviz_plugins/splat_shaders.h"

namespace tactile_clay::rviz_plugins {

// All vectors are in the frame of the camera, m; the camera looks along -z. `parallel` cameras are
// orthographic. The kernel of class surface::Kernels is weight (1 - q)^3 with q = d^T shape d.

/// The quad is perpendicular to the ray through the centre, and touches the front of the ellipsoid q = bound.
/// So it covers the ellipsoid in perspective, too.
const char* SplatShaders::corner = R"(#version 120
uniform mat4 view;
uniform mat4 projection;
uniform float bound;
varying vec3 at;
varying vec3 centre;
varying vec3 shape_x, shape_y, shape_z;
varying vec3 tint;
varying float weight;

void main() {
  vec3 first = gl_MultiTexCoord1.xyz, second = gl_MultiTexCoord2.xyz;
  mat3 turn = mat3(view);
  mat3 shape = turn * mat3(first.x, first.y, first.z, first.y, second.x, second.y, first.z, second.y, second.z) *
               transpose(turn);
  vec3 a = shape[0], b = shape[1], c = shape[2];
  mat3 extent = mat3(cross(b, c), cross(c, a), cross(a, b)) / dot(a, cross(b, c));  // the inverse of shape
  centre = (view * gl_Vertex).xyz;
  bool parallel = projection[3][3] > 0.5;
  vec3 ray = parallel ? vec3(0.0, 0.0, -1.0) : normalize(centre);
  vec3 right = normalize(cross(ray, abs(ray.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  vec3 up = cross(right, ray);
  vec2 size = sqrt(bound * vec2(dot(right, extent * right), dot(up, extent * up)));
  at = centre - sqrt(bound * dot(ray, extent * ray)) * ray + gl_MultiTexCoord0.x * size.x * right +
       gl_MultiTexCoord0.y * size.y * up;
  shape_x = a;
  shape_y = b;
  shape_z = c;
  tint = gl_MultiTexCoord3.xyz;
  weight = gl_MultiTexCoord0.z;
  gl_Position = projection * vec4(at, 1.0);
}
)";

const char* SplatShaders::front = R"(#version 120
uniform mat4 projection;
uniform float bound;
varying vec3 at;
varying vec3 centre;
varying vec3 shape_x, shape_y, shape_z;

void main() {
  vec3 ray = projection[3][3] > 0.5 ? vec3(0.0, 0.0, -1.0) : normalize(at);
  vec3 d = at - centre;
  mat3 shape = mat3(shape_x, shape_y, shape_z);
  vec3 shaped = shape * ray;
  float a = dot(ray, shaped), b = dot(d, shaped), c = dot(d, shape * d) - bound;
  float rest = b * b - a * c;
  if (rest < 0.0) discard;
  vec3 hit = at - (b + sqrt(rest)) / a * ray;
  vec4 clip = projection * vec4(hit, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
  gl_FragColor = vec4(hit.z, 0.0, 0.0, 1.0);
}
)";

/// Gradient and value of the kernel, and the colour that it gives; the card adds them up.
const char* SplatShaders::field = R"(#version 120
uniform mat4 projection;
uniform sampler2D front;
uniform vec2 pixel;
varying vec3 at;
varying vec3 centre;
varying vec3 shape_x, shape_y, shape_z;
varying vec3 tint;
varying float weight;

void main() {
  float z = texture2D(front, gl_FragCoord.xy * pixel).r;
  vec3 d = (projection[3][3] > 0.5 ? vec3(at.xy, z) : at * (z / at.z)) - centre;
  vec3 shaped = mat3(shape_x, shape_y, shape_z) * d;
  float a = 1.0 - dot(d, shaped);
  if (z == 0.0 || a <= 0.0) discard;
  float share = weight * a * a;
  gl_FragData[0] = vec4(-6.0 * share * shaped, share * a);
  gl_FragData[1] = vec4(share * a * tint, share * a);
}
)";

const char* SplatShaders::window = R"(#version 120
void main() {
  gl_Position = vec4(gl_Vertex.xy, 0.0, 1.0);
}
)";

/// One Newton step along the ray, to where the field has the level of the surface, by `farthest` at most.
const char* SplatShaders::surface = R"(#version 120
uniform mat4 projection;
uniform mat4 to_world;
uniform sampler2D front;
uniform sampler2D field;
uniform sampler2D colour;
uniform vec2 pixel;
uniform float level;
uniform float farthest;
uniform vec3 sun;
uniform vec3 fill;
uniform vec4 light;  // from below, from the sky, from the sun, from the fill

void main() {
  vec2 place = gl_FragCoord.xy * pixel;
  vec2 turned = vec2(place.x, 1.0 - place.y);  // Ogre draws textures upside down
  float z = texture2D(front, turned).r;
  if (z == 0.0) discard;
  vec4 sums = texture2D(field, turned);
  vec4 painted = texture2D(colour, turned);
  bool parallel = projection[3][3] > 0.5;
  float w = parallel ? 1.0 : -z;
  vec2 across = (2.0 * place - 1.0) * w - vec2(projection[2][0], projection[2][1]) * z -
                vec2(projection[3][0], projection[3][1]);
  vec3 at = vec3(across / vec2(projection[0][0], projection[1][1]), z);
  vec3 ray = parallel ? vec3(0.0, 0.0, -1.0) : normalize(at);
  float lacks = level - sums.w, slope = dot(sums.xyz, ray);
  at += clamp(lacks / max(slope, 1e-3), -farthest, farthest) * ray;
  vec3 normal = -normalize(mat3(to_world) * sums.xyz);
  float lit = light.x + light.y * 0.5 * (1.0 + normal.z) + light.z * max(0.0, dot(normal, sun)) +
              light.w * max(0.0, dot(normal, fill));
  vec4 clip = projection * vec4(at, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
  gl_FragColor = vec4(min(lit * painted.rgb / painted.a, 1.0), 1.0);
}
)";

}  // namespace tactile_clay::rviz_plugins
