#include <ros/init.h>
#include <ros/time.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/device_clock.h"
#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_sides.h"
#include "hand/hand_source.h"
#include "hand/repeated_hands.h"
#include "nodes/conversions.h"
#include "nodes/plugin.h"
#include "nodes/recording_time.h"
#include "nodes/share.h"
#include "nodes/topics.h"
#include "nodes/transforms.h"
#include "scene/yaml_reader.h"
#include "tools/tool_arguments.h"
#include "tools/user_paths.h"
#include "values/pose.h"
#include "values/text.h"

namespace {

constexpr char usage[] = R"(Records any source of hands into a new bag for `hands:=bag`.

  record_hands out:=FILE hands:=SOURCE [file:=...] [url:=...] [topic:=...] [duration:=S] [clean:=true]
               [tracker_pose:="x y z roll pitch yaw"]

The bag has three topics. `/hands/tracked` has the hands in the coordinate frame of the source. `/tf_static` has the
calibration, by default that of config/rig.yaml. `/hands/recording` is a std_msgs/String in YAML: the source and its
file or address, person_scale, tracker_pose, whether the hands were cleaned, and what the cleaning changed. The
program ends with the source, after `duration` s, or with Ctrl-C. It makes the folder of the bag.
)";

namespace hand = tactile_clay::hand;
namespace nodes = tactile_clay::nodes;
using Nanoseconds = std::chrono::nanoseconds;

std::sig_atomic_t volatile interrupted = 0;

struct Pose {
  std::vector<double> numbers;  // x y z roll pitch yaw
  Eigen::Isometry3d transform;
};

/// @param given x y z roll pitch yaw; empty: the pose of config/rig.yaml
Pose trackerPose(const std::string& given) {
  namespace values = tactile_clay::values;
  const auto numbers =
      given.empty()
          ? tactile_clay::scene::loadYaml(nodes::packageFolder() + "/config/rig.yaml").pose("tracker_pose")
          : values::numbersOf(given);
  if (!numbers || numbers->size() != 6)
    throw std::runtime_error("tracker_pose '" + given + "': expected x y z roll pitch yaw, 6 numbers");
  return {*numbers, values::poseOf(*numbers)};
}

/// Median size of the person's hand on one side.
class PersonScale {
 public:
  void add(const hand::TrackedHand& hand) {
    const double scale = hand::personScale(hand);
    if (std::isfinite(scale)) scales_.push_back(scale);
  }
  std::optional<double> median() {
    if (scales_.empty()) return std::nullopt;
    const auto middle = scales_.begin() + static_cast<std::ptrdiff_t>(scales_.size() / 2);
    std::nth_element(scales_.begin(), middle, scales_.end());
    return *middle;
  }

 private:
  std::vector<double> scales_;
};

/// The bag to write. Its folder is made if it is missing.
std::string newBag(const std::string& given) {
  namespace fs = std::filesystem;
  if (given.empty()) throw std::runtime_error("expected the name of a new bag in out:=");
  const char* home = std::getenv("HOME");
  const std::string bag = tactile_clay::tools::requireNewBag(
      tactile_clay::tools::userPath(given, "out", fs::current_path().string(), home == nullptr ? "" : home));
  fs::create_directories(fs::path(bag).parent_path());
  return bag;
}

class Recorder {
 public:
  explicit Recorder(const tactile_clay::tools::Arguments& arguments)
      : source_name_(arguments["hands"]),
        out_(newBag(arguments["out"])),
        duration_(arguments.number("duration", 0.0, 1e9)),
        pose_(trackerPose(arguments["tracker_pose"])),
        source_("tactile_clay::hand::HandSource", "source of hands", source_name_) {
    options_.file = arguments["file"];
    options_.url = arguments["url"];
    options_.topic = arguments["topic"];
    source_->open(options_);
    cleaned_ = source_->cleaned();
    if (arguments.flag("clean") && !cleaned_) {
      cleaner_.emplace(hand::CleanConfig());
      cleaned_ = true;
    }
  }

  void run() {
    rosbag::Bag bag(out_, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::BZ2);
    while (interrupted == 0 && ros::ok() && !over_) {
      hand::TrackedFrame frame;
      const auto read = source_->read(frame, std::chrono::milliseconds(20));
      if (const std::string fault = source_->takeFault(); !fault.empty() && fault != told_) {
        std::fprintf(stderr, "record_hands: %s\n", fault.c_str());
        told_ = fault;
      }
      if (read == hand::HandSource::Read::ended) break;
      if (read == hand::HandSource::Read::frame) write(bag, frame);
    }
    if (frames_ == 0) throw std::runtime_error("no frame came from source '" + source_name_ + "'");
    writeMetadata(bag);
    bag.close();
    std::printf("%s: %d frames, %.1f s\n", out_.c_str(), frames_, seconds());
  }

 private:
  double seconds() const { return std::chrono::duration<double>(last_ - first_).count(); }

  void write(rosbag::Bag& bag, hand::TrackedFrame& frame) {
    const auto now = std::chrono::steady_clock::now();
    Nanoseconds stamp;
    if (source_->recorded()) {
      stamp = time_(frame.stamp);
    } else {
      const bool told = frame.received != std::chrono::steady_clock::time_point();
      const Nanoseconds sampled = clock_(frame.stamp, (told ? frame.received : now).time_since_epoch());
      stamp = std::max(nodes::toCore(ros::Time::now()) - (now.time_since_epoch() - sampled),
                       last_ + std::chrono::microseconds(1));
    }
    if (frames_ == 0) first_ = stamp;
    over_ = duration_ > 0.0 && std::chrono::duration<double>(stamp - first_).count() >= duration_;
    if (over_) return;
    auto& hands = frame.hands;
    const std::size_t seen = hands.size();
    if (!source_->recorded()) repeats_.leaveOutRepeats(hands, now.time_since_epoch());
    hand::leaveOutBadHands(hands);
    if (!cleaner_) hand::keepOneHandASide(hands);
    left_out_ += seen - hands.size();
    for (const hand::TrackedHand& one : hands) scale_[static_cast<int>(one.side)].add(one);
    frame.stamp = stamp;
    if (cleaner_) cleaner_->clean(frame);
    if (frames_++ == 0) writeCalibration(bag, stamp);
    bag.write("/hands/tracked", nodes::toRos(stamp), nodes::toMessage(frame));
    last_ = stamp;
    frame_id_ = frame.frame_id;
  }

  void writeCalibration(rosbag::Bag& bag, Nanoseconds stamp) {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(nodes::transformMessage(nodes::frame::world, nodes::frame::tracker,
                                                         pose_.transform, nodes::toRos(stamp)));
    bag.write("/tf_static", nodes::toRos(stamp), message);
  }

  void writeMetadata(rosbag::Bag& bag) {
    YAML::Emitter yaml;
    yaml.SetDoublePrecision(6);
    yaml << YAML::BeginMap << YAML::Key << "source" << YAML::Value << source_name_;
    const auto add = [&](const char* key, const auto& value) {
      yaml << YAML::Key << key << YAML::Value << value;
    };
    if (!options_.file.empty()) add("file", options_.file.substr(options_.file.rfind('/') + 1));
    if (!options_.url.empty()) add("url", options_.url);
    if (source_name_ == "topic") add("topic", options_.topic);
    add("frame", frame_id_);
    add("cleaned", cleaned_);
    add("frames", frames_);
    add("duration", seconds());
    yaml << YAML::Key << "tracker_pose" << YAML::Value << YAML::Flow << pose_.numbers;
    yaml << YAML::Key << "person_scale" << YAML::Value << YAML::BeginMap;
    for (const int side : {0, 1})
      if (const auto scale = scale_[side].median()) add(side == 0 ? "left" : "right", *scale);
    yaml << YAML::EndMap;
    add("hands_left_out", left_out_ + (cleaner_ ? cleaner_->counts().doubles : 0));
    if (cleaner_) {
      const hand::CleanCounts& counts = cleaner_->counts();
      add("dropouts", counts.dropouts);
      add("id_changes", counts.id_changes);
      add("artefacts", counts.artefacts);
    }
    yaml << YAML::EndMap;
    std_msgs::String message;
    message.data = yaml.c_str();
    bag.write("/hands/recording", nodes::toRos(first_), message);
  }

  std::string source_name_, out_;
  double duration_;
  Pose pose_;
  nodes::Plugin<hand::HandSource> source_;
  hand::SourceOptions options_;
  std::optional<hand::HandCleaner> cleaner_;
  bool cleaned_ = false, over_ = false;
  nodes::RecordingTime time_;
  hand::DeviceClock clock_;
  hand::RepeatedHands repeats_{std::chrono::nanoseconds(0)};  // of a live source
  Nanoseconds first_{0}, last_{0};
  int frames_ = 0;
  std::size_t left_out_ = 0;
  PersonScale scale_[2];
  std::string frame_id_, told_;
};

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("record_hands", usage, argc, argv, [&] {
    int nothing = 0;  // number of arguments for ROS, which would take := for a remapping
    ros::init(nothing, argv, "record_hands",
              ros::init_options::NoSigintHandler | ros::init_options::AnonymousName);
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
    ros::Time::init();
    const tactile_clay::tools::Arguments arguments(argc, argv,
                                                   {{"out", ""},
                                                    {"hands", "leap_websocket"},
                                                    {"file", ""},
                                                    {"url", ""},
                                                    {"topic", "hands/tracked"},
                                                    {"duration", "0"},
                                                    {"clean", "true"},
                                                    {"tracker_pose", ""}});
    Recorder(arguments).run();
  });
}
