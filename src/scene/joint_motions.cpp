#include "scene/joint_motions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

namespace tactile_clay::scene {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse(const std::string& joint, const std::string& what) {
  throw std::runtime_error("urdf: joint '" + joint + "' " + what);
}

/// A position with its unit.
std::string text(double position, const urdf::Joint& joint) {
  std::ostringstream out;
  out << position << (joint.type == urdf::Joint::PRISMATIC ? " m" : " rad");
  return out.str();
}

void requireAxis(const urdf::Joint& joint) {
  if (joint.axis.x == 0.0 && joint.axis.y == 0.0 && joint.axis.z == 0.0)
    refuse(joint.name, "has no axis, expected one that is not zero");
}

}  // namespace

bool canMove(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::CONTINUOUS || joint.type == urdf::Joint::REVOLUTE ||
         joint.type == urdf::Joint::PRISMATIC;
}

JointMotions::JointMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions) {
  for (const auto& [name, joint] : urdf.joints_) {
    if (!canMove(*joint)) continue;
    const Link link = leaderOf(urdf, *joint);
    requireAxis(*joint);
    const bool still = !canMove(*urdf.getJoint(link.joint));
    const Range all = still ? Range{0.0, 0.0, "", "", "", ""} : Range{-infinity, infinity, "", "", "", ""};
    limit(*joint, link, tracks_.try_emplace(link.joint, Track{0.0, all, {}}).first->second.range);
    links_[name] = link;
  }
  addMotions(urdf, motions);
  for (auto& [name, track] : tracks_) {
    const Range& range = track.range;
    if (!(range.lower <= range.upper))
      refuse(name, "and what mimics it have limits that leave it no position, see those of '" +
                       range.lower_joint + "' and '" + range.upper_joint + "'");
    track.start = std::clamp(0.0, range.lower, range.upper);
    remark(urdf, name, track);
  }
}

/// The joint that a joint follows at the end of its chain; the joint itself if it mimics no other.
JointMotions::Link JointMotions::leaderOf(const urdf::ModelInterface& urdf, const urdf::Joint& joint) {
  Link link{joint.name, 1.0, 0.0};
  std::set<std::string> passed{joint.name};
  for (const urdf::Joint* at = &joint; at->mimic && canMove(*at);) {
    const urdf::JointMimic& mimic = *at->mimic;
    if (!std::isfinite(mimic.multiplier) || !std::isfinite(mimic.offset))
      refuse(at->name, "mimics '" + mimic.joint_name + "' by numbers that are not finite");
    if (!passed.insert(mimic.joint_name).second)
      refuse(joint.name, "mimics joints in a circle, by way of '" + mimic.joint_name +
                             "', expected a joint at the end that mimics none");
    const auto next = urdf.getJoint(mimic.joint_name);
    if (!next) refuse(at->name, "mimics '" + mimic.joint_name + "', expected a joint of the URDF");
    link = {mimic.joint_name, link.multiplier * mimic.multiplier,
            link.multiplier * mimic.offset + link.offset};
    at = next.get();
  }
  return link;
}

/// Narrows the range of a joint to what the limits of another one, which follows it, allow.
void JointMotions::limit(const urdf::Joint& joint, const Link& link, Range& range) {
  if (joint.type == urdf::Joint::CONTINUOUS || !joint.limits) return;
  const double lower = joint.limits->lower, upper = joint.limits->upper;
  if (!(lower <= upper))
    refuse(joint.name, "has limits from " + text(lower, joint) + " to " + text(upper, joint) +
                           ", expected the lower one first");
  if (link.multiplier == 0.0) {
    if (!(link.offset >= lower && link.offset <= upper))
      refuse(joint.name, "stays at " + text(link.offset, joint) + ", which is outside its limits");
    return;
  }
  double minimum = (lower - link.offset) / link.multiplier, maximum = (upper - link.offset) / link.multiplier;
  std::string at_least = "lower limit of " + text(lower, joint),
              at_most = "upper limit of " + text(upper, joint);
  if (link.multiplier < 0.0) {
    std::swap(minimum, maximum);
    std::swap(at_least, at_most);
  }
  if (minimum > range.lower) {
    range.lower = minimum;
    range.lower_joint = joint.name;
    range.lower_limit = at_least;
  }
  if (maximum < range.upper) {
    range.upper = maximum;
    range.upper_joint = joint.name;
    range.upper_limit = at_most;
  }
}

void JointMotions::addMotions(const urdf::ModelInterface& urdf, const std::vector<Motion>& motions) {
  for (const Motion& motion : motions) {
    const auto joint = urdf.getJoint(motion.joint);
    if (!joint)
      throw std::runtime_error("scene: motion of joint '" + motion.joint + "', expected a joint of the URDF");
    if (!canMove(*joint))
      throw std::runtime_error("scene: joint '" + motion.joint +
                               "' cannot move, expected a continuous, revolute or prismatic joint");
    if (joint->mimic)
      throw std::runtime_error("scene: motion of joint '" + motion.joint + "', which mimics '" +
                               joint->mimic->joint_name + "', expected a motion of '" +
                               links_.at(motion.joint).joint + "'");
    tracks_.at(motion.joint).motions.push_back(motion);
  }
  for (auto& [name, track] : tracks_)
    std::stable_sort(track.motions.begin(), track.motions.end(),
                     [](const Motion& a, const Motion& b) { return a.start < b.start; });
}

/// Adds remarks about joints that a motion moves faster than their limits allow.
/// @throws std::runtime_error if it moves one so fast that its position is no number
void JointMotions::remarkSpeeds(const urdf::ModelInterface& urdf, const std::string& leader,
                                const Motion& motion, std::set<std::string>& told) {
  for (const auto& [name, link] : links_) {
    if (link.joint != leader) continue;
    const double speed = (name == leader ? 1.0 : link.multiplier) * motion.velocity;
    const auto joint = urdf.getJoint(name);
    if (!(std::abs(speed) <= max_joint_speed))
      refuse(name, "is moved with " + text(speed, *joint) + "/s, expected at most " +
                       text(max_joint_speed, *joint) + "/s");
    if (joint->limits && joint->limits->velocity > 0.0 && std::abs(speed) > joint->limits->velocity &&
        told.insert("velocity of " + name).second)
      remarks_.push_back("joint '" + name + "' is moved with " + text(speed, *joint) +
                         "/s, faster than its velocity limit of " + text(joint->limits->velocity, *joint) +
                         "/s");
  }
}

/// Adds remarks about motions of a joint that its limits do not allow.
void JointMotions::remark(const urdf::ModelInterface& urdf, const std::string& name, const Track& track) {
  const auto joint = urdf.getJoint(name);
  const Range& range = track.range;
  if (track.start != 0.0)
    remarks_.push_back("joint '" + name + "' starts at " + text(track.start, *joint) +
                       ", since the limits of '" +
                       (track.start > 0.0 ? range.lower_joint : range.upper_joint) + "' do not allow 0");
  double at = track.start;
  std::set<std::string> told;
  for (const Motion& motion : track.motions) {
    remarkSpeeds(urdf, name, motion, told);
    const double end = position({at, range, {motion}}, infinity);
    const double asked = motion.velocity == 0.0 ? at : at + motion.velocity * motion.duration;
    if (asked < range.lower || asked > range.upper) {
      const bool above = asked > range.upper;
      const std::string &of = above ? range.upper_joint : range.lower_joint,
                        limit = above ? range.upper_limit : range.lower_limit;
      std::ostringstream line;
      line << "joint '" << name << "' stops at " << text(end, *joint) << " after "
           << motion.start + (end - at) / motion.velocity << " s, "
           << (of == name ? "its " : "where joint '" + of + "', which mimics it, has its ") << limit;
      if (told.insert(limit).second) remarks_.push_back(line.str());
    }
    at = end;
  }
}

double JointMotions::position(const Track& track, double t) {
  double at = track.start;
  for (const Motion& m : track.motions) {
    const double way = m.velocity == 0.0 ? 0.0 : m.velocity * std::clamp(t - m.start, 0.0, m.duration);
    at = std::clamp(at + way, track.range.lower, track.range.upper);
  }
  return at;
}

double JointMotions::position(const std::string& joint, double t) const {
  const Link& link = links_.at(joint);
  const double leading = position(tracks_.at(link.joint), t);
  return link.joint == joint ? leading : link.multiplier * leading + link.offset;
}

}  // namespace tactile_clay::scene
