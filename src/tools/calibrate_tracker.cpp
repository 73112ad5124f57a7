#include <ros/init.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/input_file.h"
#include "files/output_file.h"
#include "hand/calibration.h"
#include "hand/hand_check.h"
#include "hand/hand_source.h"
#include "nodes/plugin.h"
#include "nodes/recording_time.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] =
    R"(Finds where the tracker is in the world. Touch three or more marked points of the table from above, one after the
other, with the tip of an index finger. Keep the fingertip still on each point until the program has found it.

  calibrate_tracker points:="x y z, x y z, x y z" [out:=rig.yaml] [hands:=leap_websocket] [url:=...]
                    [file:=...] [topic:=...] [rest:=0.7] [maximum:=0.01]

`points` are in m in the coordinate frame `world`. `rest` is the time in s for which the fingertip has to stay still.
The program writes the line `tracker_pose: [...]` to `out`, in the format of config/rig.yaml. If that file exists,
only this line changes. If a touched point is more than `maximum` m off, that is an error, and nothing is written.
)";

namespace files = tactile_clay::files;
namespace hand = tactile_clay::hand;
using Eigen::Vector3d;

std::sig_atomic_t volatile interrupted = 0;

std::vector<Vector3d> points(const std::string& text) {
  std::vector<Vector3d> found;
  std::istringstream list(text);
  std::string item;
  while (std::getline(list, item, ',')) {
    std::istringstream numbers(item);
    Vector3d point;
    if (!(numbers >> point.x() >> point.y() >> point.z()) || !(numbers >> std::ws).eof())
      throw std::runtime_error("points '" + text +
                               "': expected \"x y z, x y z, x y z\", at least three points in m");
    found.push_back(point);
  }
  // Reports errors in the points before anybody touches a mark.
  hand::fitRigid(found, found);
  return found;
}

/// The index fingertip of the hand with the highest confidence.
const hand::JointPose* fingertip(hand::TrackedFrame& frame) {
  hand::leaveOutBadHands(frame.hands);
  const hand::TrackedHand* best = nullptr;
  for (const hand::TrackedHand& one : frame.hands)
    if (!one.missing[hand::index_tip] && (best == nullptr || one.confidence > best->confidence)) best = &one;
  return best == nullptr ? nullptr : &best->joints[hand::index_tip];
}

/// The places that were touched, m, in the frame of the tracker, and where they are in the world.
struct Touches {
  std::vector<Vector3d> touched, targets;
};

/// Waits until each mark was touched.
/// @param rest s, time for which a fingertip rests on each mark, as text for messages
Touches touch(hand::HandSource& source, const std::vector<Vector3d>& marks,
              const hand::TouchDetector::Config& config, const std::string& rest) {
  hand::TouchDetector detector(config);
  tactile_clay::nodes::RecordingTime time;
  Touches touches;
  std::vector<Vector3d>& touched = touches.touched;
  std::string told;
  const auto ask = [&] {
    const Vector3d& mark = marks[touched.size()];
    std::printf("touch point %zu, at (%g, %g, %g), and keep the fingertip still\n", touched.size() + 1,
                mark.x(), mark.y(), mark.z());
    std::fflush(stdout);
  };
  ask();
  while (touched.size() < marks.size()) {
    hand::TrackedFrame frame;
    const auto read = source.read(frame, std::chrono::milliseconds(100));
    if (const std::string fault = source.takeFault(); !fault.empty() && fault != told) {
      std::fprintf(stderr, "calibrate_tracker: %s\n", fault.c_str());
      told = fault;
    }
    if (interrupted != 0 || read == hand::HandSource::Read::ended)
      throw std::runtime_error(
          "only " + std::to_string(touched.size()) + " of " + std::to_string(marks.size()) +
          " points were touched, expected a fingertip at rest on each for " + rest + " s");
    if (read != hand::HandSource::Read::frame) continue;
    const double now = std::chrono::duration<double>(time(frame.stamp)).count();
    const hand::JointPose* tip = fingertip(frame);
    if (tip == nullptr) {
      detector.lose();
      continue;
    }
    const auto place = detector.add(now, tip->position);
    if (!place) continue;
    // The joint is the centre of a fingertip that lies on the mark.
    touches.targets.push_back(marks[touched.size()] + tip->radius * Vector3d::UnitZ());
    touched.push_back(*place);
    std::printf("  found at (%.4f, %.4f, %.4f) in frame %s\n", place->x(), place->y(), place->z(),
                frame.frame_id.c_str());
    if (touched.size() < marks.size()) ask();
  }
  return touches;
}

/// Writes the pose into a file; the other contents of an old file stay.
void writePose(const std::string& file, const Eigen::Isometry3d& pose) {
  namespace fs = std::filesystem;
  const bool is_new = !fs::exists(file) || (fs::is_regular_file(file) && fs::file_size(file) == 0);
  const std::string text = is_new ? "" : files::readWhole(file, files::maximum::text);
  files::writeWhole(file, hand::withTrackerPose(text, pose), files::Existing::replace);
}

void run(const tactile_clay::tools::Arguments& arguments) {
  const std::vector<Vector3d> marks = points(arguments["points"]);
  const double maximum = arguments.number("maximum", 0.0, 1.0);
  hand::TouchDetector::Config config;
  config.seconds = arguments.number("rest", 0.1, 60.0);
  hand::SourceOptions options;
  options.file = arguments["file"];
  options.url = arguments["url"];
  options.topic = arguments["topic"];
  tactile_clay::nodes::Plugin<hand::HandSource> source("tactile_clay::hand::HandSource", "source of hands",
                                                       arguments["hands"]);
  source->open(options);

  const Touches touches = touch(*source, marks, config, arguments["rest"]);
  const hand::RigidFit fit = hand::fitRigid(touches.touched, touches.targets);
  std::printf("%s\nerrors of the points: %.1f mm rms, %.1f mm at most\n",
              hand::trackerPoseLine(fit.pose).c_str(), 1e3 * fit.rms, 1e3 * fit.worst);
  if (fit.worst > maximum) {
    std::ostringstream line;
    line << "the error of a point is " << fit.worst << " m, expected at most " << maximum
         << " m: were the points touched in this order?";
    throw std::runtime_error(line.str());
  }
  if (!arguments["out"].empty()) writePose(arguments["out"], fit.pose);
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("calibrate_tracker", usage, argc, argv, [&] {
    int nothing = 0;  // number of arguments for ROS, which would take := for a remapping
    ros::init(nothing, argv, "calibrate_tracker",
              ros::init_options::NoSigintHandler | ros::init_options::AnonymousName);
    std::signal(SIGINT, [](int) { interrupted = 1; });
    const tactile_clay::tools::Arguments arguments(argc, argv,
                                                   {{"points", ""},
                                                    {"out", ""},
                                                    {"hands", "leap_websocket"},
                                                    {"file", ""},
                                                    {"url", ""},
                                                    {"topic", "hands/tracked"},
                                                    {"rest", "0.7"},
                                                    {"maximum", "0.01"}});
    run(arguments);
  });
}
