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
  output.head_spl = [this](const device::Emission& emission) -> std::optional<double> {
    const auto drive = driveOf(emission);
    return drive ? std::optional<double>(model_.headSpl(*drive)) : std::nullopt;
  };
  output.focus_pressure = [this](const device::Emission& emission) -> std::optional<double> {
    const auto drive = driveOf(emission);
    return drive ? std::optional<double>(model_.focusPressure(*drive, emission)) : std::nullopt;
  };
  output.emit = [this, most = capabilities.max_points](const device::Emission& emission,
                                                       const std_msgs::Header&) {
    if (most > 0 && emission.points.size() > most)
      throw std::runtime_error(name_ + ": " + std::to_string(emission.points.size()) +
                               " focal points, expected at most " + std::to_string(most));
    device_->submit(emission);
  };
  output.silence = [this](const std_msgs::Header&) { device_->stop(); };
  output.fault = [this] { return device_->fault(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, name_, true, std::move(output));
}

std::optional<ultrasound::Drive> ArrayDriver::driveOf(const device::Emission& emission) const {
  try {
    const auto drive = device_->drive(emission);
    return drive ? drive : model_.solve(emission);
  } catch (const std::exception&) {
    return std::nullopt;  // the gate says that it is not known
  }
}

}  // namespace tactile_clay::nodes
