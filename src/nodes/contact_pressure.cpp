#include "nodes/contact_pressure.h"

#include <algorithm>
#include <stdexcept>

#include "contact/pressure_field.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {

ContactPressure::ContactPressure(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : inbox_(private_nh),
      around_(paramIn(private_nh, "around", 0.0, 0.0, 1.0)),
      health_(nh, private_nh, "contact pressure", [this](auto& status) { diagnose(status); }) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 10;
  const auto receive = [this](const std::optional<CloudJoin::Pair>& joined) {
    if (joined) this->receive(joined->first, joined->second);
  };
  skin_ = inbox_.subscribe<Cloud>(nh, topic::hands_skin, queue, [this, receive](const Cloud::ConstPtr& skin) {
    receive(join_.addSkin(skin));
  });
  contacts_ = inbox_.subscribe<Cloud>(
      nh, topic::clay_contacts, queue,
      [this, receive](const Cloud::ConstPtr& contacts) { receive(join_.addContacts(contacts)); });
  publisher_ = nh.advertise<Cloud>(topic::hands_pressure, queue);
}

void ContactPressure::receive(const Cloud::ConstPtr& skin, const Cloud::ConstPtr& contacts) {
  ++frames_;
  sensor_msgs::PointCloud2Ptr message;
  try {
    message = pressure(*skin, *contacts);
  } catch (const std::exception& error) {
    // The frame is published empty: no pressure is felt rather than a wrong one.
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
  samples_ = 0;
  const auto forces = contactForces(contacts);
  std::vector<contact::PressureSample> samples;
  if (!forces.empty()) {
    const auto array = transforms_.lookup(skin.header.frame_id, frame::array);
    if (!array) throw std::runtime_error("the pose of the array is not known");
    const Skin pressed = pressureSkin(skin);
    if (!onSkin(contacts, pressed))
      throw std::runtime_error(
          "they do not fit to the skin of the same stamp, expected one skin for each stamp");
    std::size_t dropped = 0;
    samples = contact::pressureField(pressed, forces, array->translation().cast<float>(), &dropped);
    dropped_ += dropped;
    samples_ = samples.size();
    if (around_ > 0.0) {
      const auto around = contact::skinAround(pressed, samples, array->translation().cast<float>(),
                                              static_cast<float>(around_));
      samples.insert(samples.end(), around.begin(), around.end());
    }
    const Eigen::Isometry3f to_array = array->inverse().cast<float>();
    for (contact::PressureSample& sample : samples) {
      sample.position = to_array * sample.position;
      sample.normal = to_array.linear() * sample.normal;
      highest_ = std::max(highest_, sample.pressure);
    }
  }
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
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
