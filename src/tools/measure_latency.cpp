// Latency from motion to touch of recorded runs, stage by stage.
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/TrackedHands.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "files/ends_with.h"
#include "nodes/stage_latency.h"
#include "tools/tool_arguments.h"

namespace {

using namespace tactile_clay;

constexpr char usage[] =
    R"(Measures the latency from motion to touch of runs that were recorded live (record:=RUN.bag).

  measure_latency RUN.bag...

Prints how long each stage took, until its message came to the recorder: p50, p99 and a histogram.
doc/reference/latency.md explains what is measured. The topic rig/latency has the same numbers of a running rig.
)";
constexpr double whole_bag = 1e9;  // s
constexpr int longest_bar = 50;    // characters

/// Index of a topic in nodes::latency_topics, in any namespace; the number of these topics if it is not one
/// of them.
std::size_t placeOf(const std::string& topic) {
  const auto& all = nodes::latency_topics;
  const auto found = std::find_if(all.begin(), all.end(), [&](const char* name) {
    return files::endsWith(topic, "/" + std::string(name));
  });
  return static_cast<std::size_t>(found - all.begin());
}

ros::Time stampOf(const rosbag::MessageInstance& message) {
  if (const auto hands = message.instantiate<TrackedHands>()) return hands->header.stamp;
  if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) return cloud->header.stamp;
  if (const auto points = message.instantiate<FocalPointArray>()) return points->header.stamp;
  if (const auto state = message.instantiate<ArrayState>()) return state->header.stamp;
  throw std::runtime_error(message.getTopic() + " is of type " + message.getDataType() + ", md5 " +
                           message.getMD5Sum() + ": expected the type of this version");
}

void measure(const std::string& file) {
  rosbag::Bag bag;
  nodes::StageLatency latency(whole_bag);
  std::size_t messages = 0;
  try {
    bag.open(file);
    rosbag::View view(bag, [](const rosbag::ConnectionInfo* info) {
      return placeOf(info->topic) < nodes::latency_topics.size();
    });
    for (const rosbag::MessageInstance& message : view) {
      latency.arrived(placeOf(message.getTopic()), stampOf(message), message.getTime());
      ++messages;
    }
  } catch (const std::runtime_error& error) {  // includes rosbag::BagException
    throw std::runtime_error(file + ": " + error.what());
  }
  latency.finish();
  const RigLatency told = latency.message();
  if (told.samples.back() == 0 && told.samples.at(told.samples.size() - 2) == 0)
    throw std::runtime_error(file + ": no sample of the hands was answered by the array in " +
                             std::to_string(messages) + " messages, expected a recorded run");
  std::printf("%s: %u samples were not answered\n", file.c_str(), told.lost);
  if (told.samples.back() == 0)
    std::printf("the stamps are those of a recording: it is not known when the hands moved\n");
  std::printf("%-16s %8s %8s %8s %8s\n", "stage", "samples", "p50 ms", "p99 ms", "longest");
  for (std::size_t k = 0; k < told.stages.size(); ++k)
    if (told.samples[k] > 0)
      std::printf("%-16s %8u %8.2f %8.2f %8.2f\n", told.stages[k].c_str(), told.samples[k],
                  static_cast<double>(told.p50_ms[k]), static_cast<double>(told.p99_ms[k]),
                  static_cast<double>(told.longest_ms[k]));
  const std::size_t last = told.stages.size() - 1;
  const std::uint32_t* const counts = &told.counts[last * told.bins];
  std::uint32_t maximum = 1;
  for (std::uint32_t b = 0; b < told.bins; ++b) maximum = std::max(maximum, counts[b]);
  for (std::uint32_t b = 0; b < told.bins; ++b)
    if (counts[b] > 0)
      std::printf("%4.0f%s ms %6u %s\n", static_cast<double>(told.bin_ms) * b, b + 1 == told.bins ? "+" : " ",
                  counts[b], std::string(std::max(1u, longest_bar * counts[b] / maximum), '#').c_str());
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runTool("measure_latency", usage, argc, argv, [&] {
    if (argc < 2) throw std::runtime_error("no bag, expected measure_latency RUN.bag...");
    for (int k = 1; k < argc; ++k) measure(argv[k]);
  });
}
