#include "nodes/stop_switch.h"

#include "nodes/kept.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

/// The action; after it the mark of the file is set or removed.
std::function<std::string()> marking(const std::function<std::string()>& action, const std::string& file,
                                     bool marked) {
  return [=] {
    const std::string answer = action();
    if (!mark(file, marked))
      ROS_WARN("the emergency stop cannot be saved: this node would not know of it after a restart");
    return answer;
  };
}

}  // namespace

StopSwitch::StopSwitch(ros::NodeHandle nh, ros::NodeHandle private_nh, std::function<std::string()> stop,
                       std::function<std::string()> reset)
    : spinner_(1, &queue_) {
  const std::string file = keptFile(private_nh.getNamespace(), ".stopped");
  if (isMarked(file)) {
    stop();
    ROS_WARN("the array was started again: the earlier emergency stop is in force until it is reset");
  }
  stop = marking(stop, file, true);
  reset = marking(reset, file, false);
  nh.setCallbackQueue(&queue_);
  private_nh.setCallbackQueue(&queue_);
  for (const auto& [name, of_one, action] :
       {std::tuple(topic::array_stop, "stop", stop), {topic::array_reset, "reset", reset}}) {
    serve(nh, name, action);
    serve(private_nh, of_one, action);
    listen(nh, name, action);
  }
  spinner_.start();
}

void StopSwitch::serve(ros::NodeHandle nh, const std::string& name,
                       const std::function<std::string()>& action) {
  servers_.push_back(nh.advertiseService<std_srvs::Trigger::Request, std_srvs::Trigger::Response>(
      name, [action](std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
        response.message = action();
        response.success = true;
        return true;
      }));
}

void StopSwitch::listen(ros::NodeHandle nh, const std::string& name,
                        const std::function<std::string()>& action) {
  subscribers_.push_back(nh.subscribe<std_msgs::Empty>(
      name, 1, [action](const std_msgs::Empty::ConstPtr&) { action(); }, ros::VoidConstPtr(),
      ros::TransportHints().tcpNoDelay()));
}

}  // namespace tactile_clay::nodes
