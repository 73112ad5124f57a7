#pragma once

namespace tactile_clay::rviz_plugins {

/// Programs of the graphics card (GLSL 1.20) that draw the clay by ellipsoid splatting; class SplatScene
/// explains how they work together.
struct SplatShaders {
  static const char* corner;   // vertices: the corners of a quad that covers one ellipsoid
  static const char* front;    // fragments: distance of the first ellipsoid
  static const char* field;    // fragments: contribution of one kernel at that place
  static const char* window;   // vertices: the corners of a rectangle of the window
  static const char* surface;  // fragments: the lit surface, and its depth
};

}  // namespace tactile_clay::rviz_plugins
