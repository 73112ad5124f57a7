#include "nodes/params.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "values/pose.h"

namespace tactile_clay::nodes {
namespace {

std::vector<double> numbersParam(const ros::NodeHandle& nh, const std::string& key,
                                 const std::string& fallback, std::size_t count, const char* expected) {
  std::vector<double> numbers;
  std::string text = fallback;
  // A launch file turns a lone number into a number; everything else arrives as a text or a list.
  const bool list = nh.getParam(key, numbers);
  bool good = list || !nh.hasParam(key) || nh.getParam(key, text);
  if (good && !list) {
    std::istringstream stream(text);
    double number = 0.0;
    while (stream >> number) numbers.push_back(number);
    good = stream.eof();
  }
  for (const double number : numbers) good = good && std::isfinite(number);
  if (!good || numbers.size() != count)
    throw std::runtime_error("parameter " + nh.resolveName(key) + ": expected \"" + expected + "\", " +
                             std::to_string(count) + " numbers, got \"" +
                             (list ? "a list of other length" : text) + "\"");
  return numbers;
}

}  // namespace

Eigen::Isometry3d poseParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback) {
  return values::poseOf(numbersParam(nh, key, fallback, 6, "x y z roll pitch yaw"));
}

Eigen::Vector3d pointParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback) {
  const auto n = numbersParam(nh, key, fallback, 3, "x y z");
  return {n[0], n[1], n[2]};
}

}  // namespace tactile_clay::nodes
