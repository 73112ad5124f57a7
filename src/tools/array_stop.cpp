#include <poll.h>
#include <ros/ros.h>
#include <std_msgs/Empty.h>
#include <tactile_clay/ArrayState.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "nodes/topics.h"
#include "tools/stop_input.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] = R"(Stops every array of a graph by a key or a foot switch.

  array_stop [switch:=FILE] [__ns:=NAMESPACE]

Any key stops the arrays, `r` resets them, Ctrl-C stops them and ends the program. FILE is a foot switch: an input
device, a serial line or a FIFO. The program connects to the arrays at its start, so a stop is one small message. It
sends a stop until each array has answered in `array/state`, and also to arrays that start later. It stops the arrays
before it ends. Exits with 0 if the last stop was answered, otherwise with 1.
)";

using tactile_clay::ArrayState;
using tactile_clay::tools::FootSwitch;
using tactile_clay::tools::Keys;
using tactile_clay::tools::Wish;
namespace topic = tactile_clay::nodes::topic;

constexpr int look = 50;                       // ms, between checks for changes
const ros::WallDuration again(0.1);            // after which a stop without an answer is sent again
const ros::WallDuration answer_patience(1.0);  // after which a missing answer is reported
const ros::WallDuration leave_patience(3.0);

volatile std::sig_atomic_t interrupted = 0;

void say(const std::string& line) {
  std::printf("%s\r\n", line.c_str());  // a raw terminal does not return to the left by itself
  std::fflush(stdout);
}

/// The connection to the arrays: sends stops and resets, and hears their answers.
class Line {
 public:
  explicit Line(ros::NodeHandle nh)
      : stop_(nh.advertise<std_msgs::Empty>(
            topic::array_stop, 4, [this](const ros::SingleSubscriberPublisher& array) { greet(array); })),
        reset_(nh.advertise<std_msgs::Empty>(topic::array_reset, 4)),
        states_(nh.subscribe<ArrayState>(
            topic::array_state, 20, [this](const ros::MessageEvent<const ArrayState>& event) { hear(event); },
            ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay())) {}

  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
    told_ = false;
    answers_.clear();
    asked_ = sent_ = warned_ = ros::WallTime::now();
    stop_.publish(std_msgs::Empty());
  }

  void reset() {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = false;
    reset_.publish(std_msgs::Empty());
    say("reset: arrays sound again with the next focal points");
  }

  /// To be called again and again: reports changes, and sends a stop again that was not answered.
  /// @return whether a stop waits for its answer
  bool look() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const unsigned arrays = states_.getNumPublishers();
    if (arrays != arrays_)
      say(arrays == 0 ? "NO ARRAY is connected" : "connected to " + std::to_string(arrays) + " array(s)");
    arrays_ = arrays;
    if (!stopped_ || told_) return false;
    const ros::WallTime now = ros::WallTime::now();
    if (arrays > 0 && answers_.size() >= arrays) {
      say("STOPPED: " + std::to_string(answers_.size()) + " array(s), after " +
          std::to_string(std::lround(1e3 * (latest_ - asked_).toSec())) + " ms; r resets");
      told_ = true;
      return false;
    }
    if (now - sent_ >= again) {
      stop_.publish(std_msgs::Empty());
      sent_ = now;
    }
    if (now - warned_ >= answer_patience) {
      say("NOT CONFIRMED: " + std::to_string(answers_.size()) + " of " + std::to_string(arrays) +
          " array(s) have answered; switch off their power");
      warned_ = now;
    }
    return true;
  }

 private:
  /// Sends the stop to an array that connects while the stop is in force.
  void greet(const ros::SingleSubscriberPublisher& array) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!stopped_) return;
    array.publish(std_msgs::Empty());
    told_ = false;
  }

  void hear(const ros::MessageEvent<const ArrayState>& event) {
    const ArrayState& state = *event.getConstMessage();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (state.silent_reason.rfind("emergency stop", 0) != 0) {
      answers_.erase(event.getPublisherName());
    } else if (answers_.insert(event.getPublisherName()).second) {
      latest_ = ros::WallTime::now();
    }
  }

  mutable std::mutex mutex_;  // protects all members below
  bool stopped_ = false, told_ = false;
  unsigned arrays_ = ~0u;          // number that was reported last
  std::set<std::string> answers_;  // arrays that are stopped
  ros::WallTime asked_, sent_, latest_, warned_;
  ros::Publisher stop_, reset_;
  ros::Subscriber states_;
};

Wish waitForWish(Keys* keys, FootSwitch* foot) {
  pollfd waits[2] = {{keys ? keys->descriptor() : -1, POLLIN, 0},
                     {foot ? foot->descriptor() : -1, POLLIN, 0}};
  ::poll(waits, 2, look);
  if (interrupted != 0 || !ros::ok()) return Wish::stop_and_leave;
  if (waits[1].revents != 0) {
    const Wish wish = foot->read();
    if (foot->descriptor() < 0) say("THE SWITCH IS GONE");
    if (wish != Wish::none) return wish;
  }
  return waits[0].revents != 0 ? keys->read() : Wish::none;
}

int serve(const std::string& path) {
  std::unique_ptr<FootSwitch> foot;
  if (!path.empty()) foot = std::make_unique<FootSwitch>(path);
  Line line{ros::NodeHandle()};
  ros::AsyncSpinner spinner(1);
  spinner.start();
  auto keys = std::make_unique<Keys>(STDIN_FILENO);
  say("any key stops, r resets, Ctrl-C stops and ends");
  while (true) {
    Wish wish = waitForWish(keys.get(), foot.get());
    if (wish == Wish::ended) {
      keys.reset();  // a switch that roslaunch has started has no keys
      wish = foot ? Wish::none : Wish::stop_and_leave;
    }
    if (wish == Wish::stop || wish == Wish::stop_and_leave) line.stop();
    if (wish == Wish::reset) line.reset();
    if (wish == Wish::stop_and_leave) break;
    if (foot && foot->descriptor() < 0 && foot->reopen()) say("the switch is back");
    line.look();
  }
  const ros::WallTime until = ros::WallTime::now() + leave_patience;
  while (line.look() && ros::WallTime::now() < until) ros::WallDuration(0.01).sleep();
  return line.look() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("array_stop", usage, argc, argv, [&] {
    // Remappings and names, such as __ns:=, are for ROS.
    std::vector<char*> ours{argv[0]}, ros_own{argv[0]};
    for (int i = 1; i < argc; ++i)
      (std::string(argv[i]).rfind("__", 0) == 0 ? ros_own : ours).push_back(argv[i]);
    const tactile_clay::tools::Arguments arguments(static_cast<int>(ours.size()), ours.data(),
                                                   {{"switch", ""}});
    int count = static_cast<int>(ros_own.size());
    ros::init(count, ros_own.data(), "array_stop",
              ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
    ros::start();  // waits for a master
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { interrupted = 1; });
    return serve(arguments["switch"]);
  });
}
