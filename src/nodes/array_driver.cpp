#include "nodes/array_driver.h"

#include <visualization_msgs/MarkerArray.h>

#include <map>

#include "device/options.h"
#include "nodes/array_markers.h"
#include "nodes/drive_messages.h"
#include "nodes/gate_parameters.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

using Options = std::map<std::string, std::string>;

Options deviceOptions(const ros::NodeHandle& nh) {
  Options options;
  const std::string where = "parameter " + nh.resolveName("device_options");
  std::string text;
  if (nh.getParam("device_options", text)) {
    options = device::optionsOf(where, text);
  } else if (nh.hasParam("device_options") && !nh.getParam("device_options", options)) {
    throw std::runtime_error(where + ": expected a map of texts");
  }
  device::requireNoTemperature(where, options);
  const auto port = param<std::string>(nh, "port", "");
  if (!port.empty()) options["port"] = port;
  return options;
}

}  // namespace

ArrayDriver::ArrayDriver(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : name_(param<std::string>(private_nh, "device", "debug")),
      model_(private_nh),
      device_("tactile_clay::device::ArrayDevice", "device", name_) {
  // Checked before the device is opened.
  rulesLeftOut(private_nh, name_, device_->harmless());
  Options options = deviceOptions(private_nh);
  options["temperature"] = std::to_string(model_.acoustics.temperature);
  device_->open(options);
  const device::Capabilities capabilities = device_->capabilities();
  if (capabilities.input == device::Input::drives && capabilities.layout.size() == 0)
    throw std::runtime_error("array '" + name_ +
                             "' takes drives but has no layout, expected the positions of its transducers");
  if (capabilities.layout.size() > 0) model_.layout = capabilities.layout;
  for (const std::string& remark : capabilities.remarks) ROS_WARN("%s", remark.c_str());

  if (capabilities.input == device::Input::drives && param(private_nh, "publish_drive", true)) {
    drive_ = nh.advertise<ArrayDrive>(topic::array_drive, param(private_nh, "lockstep", false) ? 0 : 10);
    geometry_ = nh.advertise<visualization_msgs::MarkerArray>(topic::array_geometry, 1, true);
    geometry_.publish(arrayMarkers(model_.layout));
  }

  GatedArray::Output output;
  output.harmless = device_->harmless();
  output.model = model_;
  output.scalable = model_.options.amplitude_levels == 0 && !device_->drive({});
  output.solve = [this](const auto& points, const auto* before) { return solve(points, before); };
  output.solve_field = [this](const auto& targets, double amplitude, const auto& before, double effort) {
    return solveField(targets, amplitude, before, effort);
  };
  output.repertoire = {name_, capabilities.modulations, capabilities.max_rate, capabilities.max_points,
                       capabilities.slip};
  output.emit = [this](const device::Sound& sound, const std_msgs::Header& header) {
    device_->submit(sound);
    publishDrive(sound, header);
  };
  output.silence = [this](const std_msgs::Header& header) {
    device_->stop();
    if (ros::ok()) publishDrive({}, header);
  };
  output.fault = [this] { return device_->fault(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, name_, true, std::move(output));
}

void ArrayDriver::publishDrive(const device::Sound& sound, const std_msgs::Header& header) const {
  if (!drive_) return;
  for (const auto& message : driveMessages(sound, model_.layout, header)) drive_.publish(message);
}

ultrasound::PhaseSolution ArrayDriver::solve(const std::vector<ultrasound::FocalPoint>& points,
                                             const ultrasound::Drive* before) const {
  ultrasound::PhaseSolution own;
  if (auto drive = device_->drive(points)) {
    own.drive = std::move(*drive);
    return own;
  }
  return model_.solve(points, before);
}

ultrasound::FieldSolution ArrayDriver::solveField(const std::vector<ultrasound::FocalPoint>& targets,
                                                  double amplitude,
                                                  const std::vector<ultrasound::Drive>& before,
                                                  double effort) const {
  const ultrasound::FieldSolverOptions options = model_.fieldOptions(amplitude, effort);
  if (auto own = device_->field(targets, options, before)) return *own;
  return model_.solveField(targets, amplitude, before, effort);
}

}  // namespace tactile_clay::nodes
