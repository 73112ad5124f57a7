#pragma once

#include <urdf_model/model.h>

#include <map>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace tactile_clay::scene {

/// Whether a joint has one position that can change: a continuous, revolute or prismatic joint.
bool canMove(const urdf::Joint& joint);

/// Positions of the joints of a model over time.
///
/// The motions of a joint follow one another, each from where the one before left it. Limits of the URDF stop
/// them. A joint that mimics another is at multiplier * position + offset of it, through any chain of joints;
/// as they are one mechanism, what stops one of them stops all.
class JointMotions {
 public:
  /// @param motions those of one joint do not overlap
  /// @throws std::runtime_error with one line: a motion of no joint, of one that cannot move, has no axis or
  /// mimics another, joints that mimic each other in a circle, limits that leave nothing
  JointMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions);

  /// rad or m, of a joint that can move, at time t (s).
  double position(const std::string& joint, double t) const;

  /// Limits that stop a motion or are left out, and joints that do not start at 0, a line each.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  struct Range {
    double lower, upper;                   // rad or m
    std::string lower_joint, upper_joint;  // whose limits these are
    std::string lower_limit, upper_limit;  // which of these, and where, in words
  };
  struct Track {   // of a joint that mimics none
    double start;  // rad or m
    Range range;
    std::vector<Motion> motions;  // by time
  };
  struct Link {  // to a joint that mimics none: position = multiplier * position of it + offset
    std::string joint;
    double multiplier = 1.0, offset = 0.0;
  };
  static Link leaderOf(const urdf::ModelInterface& urdf, const urdf::Joint& joint);
  void limit(const urdf::Joint& joint, const Link& link, Range& range);
  void addMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions);
  void remark(const urdf::ModelInterface& urdf, const std::string& joint, const Track& track);
  static double position(const Track& track, double t);

  std::map<std::string, Track> tracks_;
  std::map<std::string, Link> links_;  // of every joint that can move
  std::vector<std::string> remarks_;
};

}  // namespace tactile_clay::scene
