#include "nodes/array_driver.h"

#include <map>
#include <sstream>

#include "nodes/params.h"

namespace tactile_clay::nodes {
namespace {

using Options = std::map<std::string, std::string>;

Options deviceOptions(const ros::NodeHandle& nh) {
  Options options;
  std::string text;
  if (nh.getParam("device_options", text)) {
    // Words without a '=' belong to the value before them, as the numbers of a pose do.
    std::istringstream words(text);
    std::string word, key;
    while (words >> word) {
      const std::size_t at = word.find('=');
      if (at != std::string::npos && at > 0) {
        key = word.substr(0, at);
        options[key] = word.substr(at + 1);
      } else if (!key.empty()) {
        options[key] += " " + word;
      } else {
        throw std::runtime_error("parameter " + nh.resolveName("device_options") + ": '" + text +
                                 "', expected key=value ...");
      }
    }
  } else if (nh.hasParam("device_options") && !nh.getParam("device_options", options)) {
    throw std::runtime_error("parameter " + nh.resolveName("device_options") + ": expected a map of texts");
  }
  const auto port = param<std::string>(nh, "port", "");
  if (!port.empty()) options["port"] = port;
  return options;
}

}  // namespace

ArrayDriver::ArrayDriver(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : name_(param<std::string>(private_nh, "device", "debug")),
      model_(private_nh),
      device_("tactile_clay::device::ArrayDevice", "device", name_) {
  Options options = deviceOptions(private_nh);
  options.emplace("temperature", std::to_string(model_.acoustics.temperature));
  device_->open(options);
  const device::Capabilities capabilities = device_->capabilities();
  if (capabilities.layout.size() > 0) model_.layout = capabilities.layout;

  GatedArray::Output output;
  output.loudness = [this](const auto& points) { return loudness(points); };
  output.modulations = capabilities.modulations;
  output.max_rate = capabilities.max_rate;
  output.max_points = capabilities.max_points;
  output.emit = [this](const device::Emission& emission, const std_msgs::Header&) {
    device_->submit(emission);
  };
  output.silence = [this](const std_msgs::Header&) { device_->stop(); };
  output.fault = [this] { return device_->fault(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, name_, true, std::move(output));
}

device::Loudness ArrayDriver::loudness(const std::vector<ultrasound::FocalPoint>& points) const {
  try {
    auto drive = device_->drive(points);
    if (!drive)
      drive = ultrasound::solvePhases(model_.layout, model_.acoustics, points, model_.options).drive;
    return model_.loudness(*drive, points);
  } catch (const std::exception&) {
    return {};  // the gate says that it is not known
  }
}

}  // namespace tactile_clay::nodes
