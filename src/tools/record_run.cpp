// Records a run of the rig of its namespace without losing messages.
//
//   record_run --help
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <std_msgs/Header.h>
#include <tactile_clay/ArrayState.h>
#include <topic_tools/shape_shifter.h>

#include <algorithm>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "nodes/exit_code.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "tools/tool_arguments.h"
#include "tools/user_paths.h"

namespace {

using namespace tactile_clay;
using Message = topic_tools::ShapeShifter;

constexpr const char* usage = R"(usage: record_run [_PARAMETER:=VALUE]...

Records the topics of the rig of its namespace into a bag. Unlike `rosbag record` it drops no message, even if the
disk or the compression is slow. A rig in lockstep waits for it. record.launch starts it.

  _bag:=FILE         the new bag, whose folder is made; empty: tactile_clay_DATE.bag in ~folder
  _folder:=FOLDER    folder of that bag                                        [.]
  _skin:=true|false  whether hands/skin is recorded                         [true]
  _compression:=HOW  none, lz4 or bz2                                       [none]
  _topics:="A B"     these topics, instead of those of the rig                  []
)";

// Topics below the namespace of the rig. {skin} may be left out.
constexpr const char* topics_of_rig =
    "rig/(description|changes|numbers)|[^/]+/parameter_updates|joint_states|trial/(instruction|state|answer)|"
    "hands/(tracked|{skin}bones|pressure|joint_states_left|joint_states_right)|clay/"
    "(particles|contacts|status)|"
    "array/(focal_points|rendering|acoustics|state|drive|measured|field|geometry)";

constexpr double look_period = 0.2;  // s, between questions to the master for new topics
// s. When the recorder is asked to end, it goes on until nothing has come for `silence`: messages that were
// sent before are still on their way, and come slowly if the computer is busy. A rig that goes on is never
// silent, so the recorder ends after `max_ending` at the latest.
constexpr double silence = 0.3, max_ending = 2.0;

volatile std::sig_atomic_t asked_to_end = 0;

rosbag::CompressionType compressionNamed(const std::string& name) {
  if (name == "none") return rosbag::compression::Uncompressed;
  if (name == "lz4") return rosbag::compression::LZ4;
  if (name == "bz2") return rosbag::compression::BZ2;
  throw std::runtime_error("compression '" + name + "', expected one of none, lz4, bz2");
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), std::istream_iterator<std::string>()};
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d-%H-%M-%S", &local);
  return text;
}

/// The bag that the parameters ask for, which is new. Makes its folder.
std::string newBag(const ros::NodeHandle& private_nh) {
  std::string bag = nodes::param<std::string>(private_nh, "bag", "");
  if (bag.empty())
    bag = nodes::param<std::string>(private_nh, "folder", ".") + "/tactile_clay_" + today() + ".bag";
  bag = tools::requireNewBag(std::filesystem::absolute(bag).string());
  std::filesystem::create_directories(std::filesystem::path(bag).parent_path());
  return bag;
}

/// Topics of this rig only: another rig may run at the same time.
std::regex topicsOfRig(const ros::NodeHandle& nh, bool skin) {
  std::string below = topics_of_rig;
  const std::string place = "{skin}";
  below.replace(below.find(place), place.size(), skin ? "skin|" : "");
  const std::string space = nh.getNamespace();
  return std::regex(nh.resolveName("/tf") + "|" + nh.resolveName("/tf_static") + "|/diagnostics|" +
                    (space.back() == '/' ? space : space + "/") + "(" + below + ")");
}

class Recorder {
 public:
  /// @throws std::runtime_error with one line if a parameter is wrong or the bag cannot be made
  Recorder(ros::NodeHandle nh, const ros::NodeHandle& private_nh)
      : nh_(nh),
        named_(words(nodes::param<std::string>(private_nh, "topics", ""))),
        of_rig_(topicsOfRig(nh, nodes::param(private_nh, "skin", true))),
        answers_(nh.resolveName(nodes::topic::array_state)) {
    const auto compression = compressionNamed(nodes::param<std::string>(private_nh, "compression", "none"));
    path_ = newBag(private_nh);
    bag_.open(path_ + ".active", rosbag::bagmode::Write);
    bag_.setCompression(compression);
    for (const std::string& topic : named_) subscribe(nh_.resolveName(topic));
    ROS_INFO("record: to '%s'", path_.c_str());
  }

  /// Records until it is asked to end.
  void run() {
    ros::SteadyTime looked;
    while (ros::ok() && asked_to_end == 0) {
      if (const ros::SteadyTime now = ros::SteadyTime::now(); (now - looked).toSec() >= look_period) {
        looked = now;
        look();
      }
      queue_.callAvailable(ros::WallDuration(0.05));
    }
    const ros::SteadyTime asked = ros::SteadyTime::now();
    came_ = asked;
    for (ros::SteadyTime now = asked;
         ros::ok() && (now - asked).toSec() < max_ending && (now - came_).toSec() < silence;
         now = ros::SteadyTime::now())
      queue_.callAvailable(ros::WallDuration(0.02));
    queue_.callAvailable();  // all messages that have come by now
    bag_.close();
    std::filesystem::rename(path_ + ".active", path_);
  }

 private:
  void look() {
    if (!named_.empty()) return;
    ros::master::V_TopicInfo published;
    if (!ros::master::getTopics(published)) return;
    constexpr std::size_t longest = 1000;  // bytes of a name; std::regex takes stack for each
    for (const ros::master::TopicInfo& topic : published)
      if (subscribers_.count(topic.name) == 0 && topic.name.size() <= longest &&
          std::regex_match(topic.name, of_rig_))
        subscribe(topic.name);
  }

  void subscribe(const std::string& topic) {
    // The rig waits only for a recorder that records answers: it confirms them on this topic.
    if (topic == answers_) recorded_ = nh_.advertise<std_msgs::Header>(nodes::topic::recorded, 0);
    ros::SubscribeOptions options;
    options.topic = topic;
    options.queue_size = 0;  // unlimited
    options.md5sum = ros::message_traits::md5sum<Message>();
    options.datatype = ros::message_traits::datatype<Message>();
    using Event = ros::MessageEvent<const Message>;
    options.helper = boost::make_shared<ros::SubscriptionCallbackHelperT<const Event&>>(
        [this, topic](const Event& event) { write(topic, event); });
    options.callback_queue = &queue_;
    options.transport_hints = ros::TransportHints().tcpNoDelay();
    subscribers_[topic] = nh_.subscribe(options);
  }

  void write(const std::string& topic, const ros::MessageEvent<const Message>& event) {
    const Message& message = *event.getMessage();
    bag_.write(topic, std::max(event.getReceiptTime(), ros::TIME_MIN), message,
               event.getConnectionHeaderPtr());
    came_ = ros::SteadyTime::now();
    if (topic != answers_ || message.getMD5Sum() != ros::message_traits::md5sum<ArrayState>()) return;
    recorded_.publish(message.instantiate<ArrayState>()->header);
  }

  ros::NodeHandle nh_;
  std::vector<std::string> named_;
  std::regex of_rig_;
  std::string answers_;  // topic whose messages are the last of a sample
  std::string path_;     // of the bag when it is complete
  rosbag::Bag bag_;
  ros::SteadyTime came_;      // when the last message had been written
  ros::CallbackQueue queue_;  // its own queue, because ROS empties the global one when it ends
  std::map<std::string, ros::Subscriber> subscribers_;
  ros::Publisher recorded_;
};

void run(int argc, char** argv) {
  ros::init(argc, argv, "record", ros::init_options::NoSigintHandler);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { asked_to_end = 1; });
  ros::NodeHandle nh, private_nh("~");
  nodes::failWhenReplaced();
  Recorder(nh, private_nh).run();
}

}  // namespace

int main(int argc, char** argv) {
  const int code = tools::runTool("record", usage, argc, argv, [&] { run(argc, argv); });
  return std::max(code, nodes::exitCode());
}
