#include "nodes/inbox.h"

#include "values/text.h"

namespace tactile_clay::nodes {

Inbox::Inbox(const ros::NodeHandle& private_nh) : node_(private_nh.getNamespace()) {
  if (!node_.empty() && node_.front() == '/') node_.erase(0, 1);
}

void Inbox::refuse(const std::string& topic, const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Topic& mine = topics_[topic];
  ++mine.refused;
  if (const auto more = mine.lines.pass())
    ROS_WARN("%s: message on %s left out%s: %s", node_.c_str(), topic.c_str(), andMore(*more).c_str(),
             values::printableLine(reason).c_str());
}

void Inbox::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto& [topic, mine] : topics_) {
    if (mine.refused > 0) status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, "messages left out");
    status.add("messages left out on " + topic, mine.refused);
    mine.refused = 0;
  }
}

}  // namespace tactile_clay::nodes
