// Where recorded hands are given something to feel: hands, skin, clay, pressure and focal points of the
// graph, in one process, with the messages between them.
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_shape.h"
#include "hand/kinematic_hand.h"
#include "hand/soft_hands.h"
#include "nodes/conversions.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "support/hand_recording.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {
namespace {

const std::string package = TACTILE_CLAY_SOURCE_DIR;
constexpr double off_skin = 3e-3;                          // m, at most, of a focal point
const Eigen::Vector3d tracker(0.0, 0.0, -0.09);            // m, config/rig.yaml
const Eigen::Vector3f array_position(0.0f, 0.0f, -0.15f);  // m, the same
constexpr double skin_spacing = 0.005;                     // m
constexpr double clay_spacing = 0.007;  // m; coarse, for what matters here is where it presses, not how

std::vector<hand::TrackedFrame> framesOfBag(const std::string& name) {
  rosbag::Bag bag(package + "/test/bags/" + name + ".bag");
  std::vector<hand::TrackedFrame> frames;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    hand::TrackedFrame frame = toCore(*message.instantiate<TrackedHands>());
    hand::leaveOutBadHands(frame.hands);
    frames.push_back(frame);
  }
  return frames;
}

/// As hand_tracking releases them.
std::optional<std::vector<hand::TrackedFrame>> framesOfRecording(const std::string& name) {
  auto frames = hand::recordedFrames(name);
  if (!frames) return frames;
  hand::HandCleaner cleaner{hand::CleanConfig()};
  for (hand::TrackedFrame& frame : *frames) {
    hand::leaveOutBadHands(frame.hands);
    cleaner.clean(frame);
    for (hand::TrackedHand& hand : frame.hands)
      for (hand::JointPose& joint : hand.joints) joint.position += tracker;
  }
  return frames;
}

/// The rig from tracked hands to focal points.
template <class Hands>
class Rig {
 public:
  explicit Rig(const std::string& scene)
      : scene_(scene::loadScene(scene, package, clay_spacing)), hands_(skin_spacing) {
    scene_.config.budget = scene::loadQuality("fast", package);
    solids_ = std::make_unique<scene::Solids>(scene::readText(scene_.urdf), scene_.motions);
    clay_ = std::make_unique<clay::Clay>(scene_.config, scene_.materials, scene_.particles);
    renderer_.setArray(ultrasound::ArrayReach(ultrasound::arrayLayout("usx"), ultrasound::Acoustics()));
  }

  /// Places in the world.
  std::vector<Eigen::Vector3d> focalPoints(const hand::TrackedFrame& frame) {
    std_msgs::Header header;
    header.stamp = toRos(frame.stamp);
    const auto skin = skinCloud(hands_.update(frame.hands, frame.stamp), header);
    const double dt = last_ ? std::chrono::duration<double>(frame.stamp - *last_).count() : 1.0 / 60.0;
    last_ = frame.stamp;
    const Skin pressing = claySkin(*skin);
    clay_->advance(pressing, solids_->solids(), solids_->motion(), std::min(dt, 1.0));
    const auto contacts = contactCloud(clay_->skinForces(), pressing, *skin);
    const auto forces = contactForces(*contacts);
    react(frame.stamp, forces);
    const Skin pressed = pressureSkin(*skin);
    EXPECT_TRUE(onSkin(*contacts, pressed));
    std::vector<contact::PressureSample> samples = contact::pressureField(pressed, forces, array_position);
    for (contact::PressureSample& sample : samples) sample.position -= array_position;
    std::vector<Eigen::Vector3d> places;
    for (const ultrasound::FocalPoint& point :
         renderer_.render(pressureSamples(*pressureCloud(samples, header))))
      places.push_back(point.position + array_position.cast<double>());
    return places;
  }

 private:
  void react(std::chrono::nanoseconds stamp, const std::vector<SkinForce>& contacts) {
    if constexpr (std::is_same_v<Hands, hand::SoftHands>) {
      EXPECT_EQ(hands_.react(stamp, contacts), 0u);
    }
  }

  scene::Scene scene_;
  Hands hands_;
  std::unique_ptr<scene::Solids> solids_;
  std::unique_ptr<clay::Clay> clay_;
  ultrasound::FocalPointRenderer renderer_;
  std::optional<std::chrono::nanoseconds> last_;
};

/// From the surface of the tracked hands, on the bones that were seen, m.
double fromSkin(const std::vector<hand::TrackedHand>& hands, const Eigen::Vector3d& point) {
  double closest = std::numeric_limits<double>::infinity();
  for (const hand::TrackedHand& hand : hands) {
    double distance = std::numeric_limits<double>::infinity();
    for (const hand::Bone& bone : hand::bones)
      if (!hand.missing[bone.from] && !hand.missing[bone.to])
        distance = std::min(distance, hand::boneCapsule(bone, hand).distance(point));
    closest = std::min(closest, std::abs(distance));
  }
  return closest;
}

/// @return how many focal points there were
template <class Hands>
std::size_t expectOnSkin(const std::string& name, const std::vector<hand::TrackedFrame>& frames,
                         const std::string& scene) {
  Rig<Hands> rig(scene);
  std::size_t points = 0;
  double worst = 0.0;
  for (const hand::TrackedFrame& frame : frames)
    for (const Eigen::Vector3d& point : rig.focalPoints(frame)) {
      worst = std::max(worst, fromSkin(frame.hands, point));
      ++points;
    }
  std::printf("%s: %zu frames, %zu focal points, worst %.2f mm from the skin\n", name.c_str(), frames.size(),
              points, 1e3 * worst);
  EXPECT_LE(worst, off_skin) << name;
  return points;
}

template <class Hands>
class FocalPoints : public ::testing::Test {};
using Models = ::testing::Types<hand::KinematicHands, hand::SoftHands>;
TYPED_TEST_SUITE(FocalPoints, Models);

TYPED_TEST(FocalPoints, OfShippedBagsLieOnTheTrackedSkin) {
  EXPECT_GT(expectOnSkin<TypeParam>("knead", framesOfBag("knead"), "kindergarten"), 500u);
  EXPECT_GT(expectOnSkin<TypeParam>("potter", framesOfBag("potter"), "potters_wheel"), 300u);
  EXPECT_GT(expectOnSkin<TypeParam>("lost_hand", framesOfBag("lost_hand"), "kindergarten"), 5u);
}

TYPED_TEST(FocalPoints, OfRecordingsLieOnTheTrackedSkin) {
  for (const char* name : hand_recordings) {
    const auto frames = framesOfRecording(name);
    if (!frames) GTEST_SKIP() << "no recording " << name;
    expectOnSkin<TypeParam>(name, *frames, "kindergarten");
  }
}

}  // namespace
}  // namespace tactile_clay::nodes
