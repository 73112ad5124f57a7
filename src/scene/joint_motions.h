#pragma once

#include <urdf_model/model.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace tactile_clay::scene {

/// Whether a joint has one position that can change: a continuous, revolute or prismatic joint.
bool canMove(const urdf::Joint& joint);

/// Positions of the joints of a model over time.
///
/// The motions of a joint follow one another, each from where the motion before left the joint. Limits of the
/// URDF stop them. A joint that mimics another joint is at multiplier * position + offset of that joint,
/// through any chain of joints. These joints are one mechanism: a limit that stops one of them stops all.
class JointMotions {
 public:
  /// @param motions the motions of one joint do not overlap
  /// @throws std::runtime_error with one line: a motion of a joint that does not exist, cannot move, has no
  ///   axis or mimics another; joints that mimic each other in a circle; limits that allow no position;
  ///   a joint that is moved faster than max_joint_speed
  JointMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions);

  /// Position, rad or m, of a joint that can move, at time t (s).
  double position(const std::string& joint, double t) const;

  /// Limits that stop a motion or are ignored, and joints that do not start at 0, one line each.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  struct Range {
    double lower, upper;                   // rad or m
    std::string lower_joint, upper_joint;  // whose limits these are
    std::string lower_limit, upper_limit;  // the limits in words
  };
  struct Track {   // motions of a joint that mimics no other
    double start;  // rad or m
    Range range;
    std::vector<Motion> motions;  // by time
  };
  struct Link {  // to a joint that mimics no other: position = multiplier * its position + offset
    std::string joint;
    double multiplier = 1.0, offset = 0.0;
  };
  static Link leaderOf(const urdf::ModelInterface& urdf, const urdf::Joint& joint);
  void limit(const urdf::Joint& joint, const Link& link, Range& range);
  void addMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions);
  void remarkSpeeds(const urdf::ModelInterface& urdf, const std::string& leader, const Motion& motion,
                    std::set<std::string>& told);
  void remark(const urdf::ModelInterface& urdf, const std::string& joint, const Track& track);
  static double position(const Track& track, double t);

  std::map<std::string, Track> tracks_;
  std::map<std::string, Link> links_;  // of every joint that can move
  std::vector<std::string> remarks_;
};

}  // namespace tactile_clay::scene
