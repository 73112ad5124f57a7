#include "nodes/contact_pressure.h"

#include <algorithm>
#include <stdexcept>

#include "contact/pressure_field.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

// Skins wait here for their contacts; live, those that the clay skipped are pushed out.
constexpr int join_queue = 100;

}  // namespace

ContactPressure::ContactPressure(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : hints_(ros::TransportHints().tcpNoDelay()),
      join_(join_queue),
      health_(nh, private_nh, "contact pressure", [this](auto& status) { diagnose(status); }) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 10;
  join_.connectInput(skin_, contacts_);
  join_.registerCallback(&ContactPressure::receive, this);
  skin_.subscribe(nh, topic::hands_skin, queue, hints_);
  contacts_.subscribe(nh, topic::clay_contacts, queue, hints_);
  publisher_ = nh.advertise<Cloud>(topic::hands_pressure, queue);
}

void ContactPressure::receive(const Cloud::ConstPtr& skin, const Cloud::ConstPtr& contacts) {
  ++frames_;
  sensor_msgs::PointCloud2Ptr message;
  try {
    message = pressure(*skin, *contacts);
  } catch (const std::exception& error) {
    // The frame goes on empty: what cannot be felt rightly is not felt.
    ++bad_frames_;
    ROS_WARN_THROTTLE(1.0, "contact_pressure: contacts left out: %s", error.what());
    std_msgs::Header header = contacts->header;
    header.frame_id = frame::array;
    message = pressureCloud({}, header);
  }
  publisher_.publish(message);
}

sensor_msgs::PointCloud2Ptr ContactPressure::pressure(const Cloud& skin, const Cloud& contacts) {
  std_msgs::Header header = contacts.header;
  header.frame_id = frame::array;
  const auto forces = contactForces(contacts);
  std::vector<contact::PressureSample> samples;
  if (!forces.empty()) {
    const auto array = transforms_.lookup(skin.header.frame_id, frame::array, ros::Time(0));
    if (!array) throw std::runtime_error("the pose of the array is not known");
    std::size_t dropped = 0;
    samples = contact::pressureField(pressureSkin(skin).view(), forces, array->translation().cast<float>(),
                                     &dropped);
    dropped_ += dropped;
    const Eigen::Isometry3f to_array = array->inverse().cast<float>();
    for (contact::PressureSample& sample : samples) {
      sample.position = to_array * sample.position;
      sample.normal = to_array.linear() * sample.normal;
      highest_ = std::max(highest_, sample.pressure);
    }
  }
  samples_ = samples.size();
  return pressureCloud(samples, header);
}

void ContactPressure::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (bad_frames_ > 0 || dropped_ > 0)
    status.summary(Level::WARN, "contacts left out");
  else
    status.summary(Level::OK, frames_ > 0 ? "rendering" : "no frames");
  status.add("frames", frames_);
  status.add("frames left out", bad_frames_);
  status.add("contacts left out", dropped_);
  status.add("pressed samples", samples_);
  status.add("highest pressure, Pa", highest_);
  frames_ = bad_frames_ = 0;
  dropped_ = 0;
  highest_ = 0.0f;
}

}  // namespace tactile_clay::nodes
