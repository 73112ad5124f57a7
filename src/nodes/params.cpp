#include "nodes/params.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include "values/pose.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

/// The value of a parameter in one line, for error lines.
std::string written(XmlRpc::XmlRpcValue value) {
  std::ostringstream out;
  out << value;
  return values::printableLine(out.str());
}

std::vector<double> numbersParam(const ros::NodeHandle& nh, const std::string& key,
                                 const std::string& fallback, std::size_t count, const char* expected) {
  std::vector<double> elements;
  std::string text = fallback;
  std::optional<std::vector<double>> numbers;
  XmlRpc::XmlRpcValue value;
  const bool given = nh.getParam(key, value);
  // A launch file turns a lone number into a number; everything else arrives as a text or a list.
  if (nh.getParam(key, elements))
    numbers = elements;
  else if (!given || nh.getParam(key, text))
    numbers = values::numbersOf(text);
  if (!numbers || numbers->size() != count ||
      !std::all_of(numbers->begin(), numbers->end(), [](double number) { return std::isfinite(number); }))
    throw std::runtime_error("parameter " + nh.resolveName(key) + ": expected \"" + expected + "\", " +
                             std::to_string(count) + " numbers, got \"" + (given ? written(value) : text) +
                             "\"");
  return *numbers;
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
