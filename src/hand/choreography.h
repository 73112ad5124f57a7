#pragma once

#include <Eigen/Core>

#include "hand/score.h"

namespace tactile_clay::hand {

/// Two palm-down hands come in from the user's side, knead blocks that stand on z = 0 within 0.1 m of the
/// origin, and leave. Each stroke presses with the heel, rolls over the palm to the fingers, curls them into
/// the clay and draws it back; the right hand is 0.75 s behind the left one.
struct Knead {
  double scale = 1.05;          // of the person
  double block_height = 0.045;  // m, 35 to 50 mm
  double depth = 0.025;         // m, how far the lowest skin goes below the block's top
  double aside = 0.07;          // m, distance of each palm from the plane y = 0
  double draw = 0.01;           // m, how far the clay is drawn back
  int strokes = 2;              // for each hand, 4.4 s each
};
Score knead(const Knead& parameters = {});

/// The right index finger pokes a block from above and leaves it.
struct PressFinger {
  double scale = 1.05;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m, of the block
  double block_height = 0.04;                        // m
  double approach = 0.06;                            // m above the block's top at start and end
  double depth = 0.01;                               // m below the block's top
  double speed = 0.03;                               // m/s, from touch to depth
  double hold = 0.5;                                 // s
};
Score pressFinger(const PressFinger& parameters = {});

/// The pad of the right thumb presses a block of at most 0.04 m of width from above and leaves it, with times
/// and distances as in pressFinger. The other fingers are a fist.
Score pressThumb(const PressFinger& parameters = {});

/// The whole right palm presses a block from above and leaves it, with times and distances as in pressFinger.
Score flatPress(const PressFinger& parameters = {});

/// Two hands close on an upright cylinder around the origin that stands on z = 0, press it narrower over two
/// turns of a wheel of 60 rpm, rise a little and leave. Hands that lean over it make a cone of it. With
/// `top`, they then hold it with little pressure while their thumbs press its top down.
struct Potter {
  double scale = 1.05;
  double radius = 0.05;   // m, at half the height
  double height = 0.065;  // m
  double depth = 0.004;   // m
  double low = 0.005;     // m, of the lowest skin above z = 0, at first
  double rise = 0.06;     // how far they rise while they press, share of the height
  double lean = 0.0;      // rad, of the palms from upright toward the axis, at most 45 degrees
  double top = 0.0;       // m, height to which the thumbs then press the clay's top; 0: they stay up
};
Score potter(const Potter& parameters = {});

/// The right thumb, and index and middle finger to its right, close on a block from above along y, squeeze it
/// and let it go.
struct Pinch {
  double scale = 1.05;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m, of the block
  double block_height = 0.04;                        // m
  double approach = 0.06;                            // m above the place of the grip, at start and end
  double reach = 0.012;                              // m, how far the fingertips go below the block's top
  double width = 0.03;                               // m, of the block between thumb and fingers
  double depth = 0.006;                              // m, by how much the block becomes narrower
  int times = 2;
};
/// @throws std::invalid_argument also if a hand of this scale cannot open or close so far
Score pinch(const Pinch& parameters = {});

/// The flat right palm presses on a block and rolls it forth and back.
struct Roll {
  double scale = 1.05;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m, of the block
  double block_height = 0.04;                        // m
  double approach = 0.06;                            // m above the block's top at start and end
  double depth = 0.008;                              // m below the block's top
  double travel = 0.03;                              // m, to each side of the centre
  int times = 3;                                     // forth and back, 1.6 s each
};
Score roll(const Roll& parameters = {});

}  // namespace tactile_clay::hand
