#include "nodes/array_driver.h"

#include <map>

#include "nodes/params.h"

namespace tactile_clay::nodes {

ArrayDriver::ArrayDriver(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : name_(param<std::string>(private_nh, "device", "debug")),
      model_(private_nh),
      device_("tactile_clay::device::ArrayDevice", "device", name_) {
  std::map<std::string, std::string> options;
  private_nh.getParam("device_options", options);
  const auto port = param<std::string>(private_nh, "port", "");
  if (!port.empty()) options["port"] = port;
  device_->open(options);
  GatedArray::Output output;
  output.head_spl = [this](const device::Emission& emission) { return model_.headSpl(emission); };
  output.emit = [this](const device::Emission& emission, const std_msgs::Header&) {
    device_->submit(emission);
  };
  output.silence = [this](const std_msgs::Header&) { device_->stop(); };
  output.fault = [this] { return device_->fault(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, name_, true, std::move(output));
}

}  // namespace tactile_clay::nodes
