#include <ros/ros.h>
#include <signal.h>
#include <std_msgs/Empty.h>
#include <std_srvs/Trigger.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <tactile_clay/FocalPointArray.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "device/sonic_surface_terminal.h"
#include "nodes/topics.h"
#include "safety/silence_times.h"
#include "tools/quantile.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] =
    R"(Measures how long an emergency stop takes, from the call until the boards are silent.

  measure_stop [rounds:=100] [busy:=2] [by:=service|topic] [device_options:='...'] [modulation_frequency:=200]

Simulates SonicSurface boards behind a serial port. Starts an `array_driver` for them, and busy loops beside it. Sends
focal points that move, at 60 Hz. Stops and resets the array again and again, over a connection that stays open. A
byte counts as received when the wire of real boards would have transmitted it. Prints LATE if the 99th percentile is
longer than `silence_times::stop`. Exits with 1 if the boards sounded after a stop. Needs a master.
)";

using namespace std::chrono_literals;
using namespace tactile_clay;
using Clock = std::chrono::steady_clock;
using device::SonicSurfaceTerminal;

constexpr auto patience = 20s;             // for a sound
constexpr auto settled = 60ms;             // of sound before a stop, and of silence after it
constexpr char space[] = "/measure_stop";  // namespace: no other array receives these messages
constexpr double frame_rate = 60.0;        // Hz

/// A process that ends with this one.
class Child {
 public:
  template <class Run>
  explicit Child(const Run& run) : process_(::fork()) {
    if (process_ < 0) throw std::runtime_error("a process cannot be started");
    if (process_ > 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    run();
    ::_exit(127);
  }
  Child(Child&& other) noexcept : process_(std::exchange(other.process_, 0)) {}
  ~Child() {
    if (process_ <= 0) return;
    ::kill(process_, SIGINT);
    for (int i = 0; i < 300 && ::waitpid(process_, nullptr, WNOHANG) == 0; ++i)
      std::this_thread::sleep_for(10ms);
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }

 private:
  pid_t process_;
};

std::string programBeside(const std::string& name) {
  char path[4096];
  const ssize_t length = ::readlink("/proc/self/exe", path, sizeof path);
  const std::string own(path, static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  return own.substr(0, own.rfind('/') + 1) + name;
}

/// Focal points that move, so that each frame is a new pattern on the wire.
void stream(ros::NodeHandle nh, double modulation_frequency, const std::atomic<bool>& ends) {
  auto publisher = nh.advertise<FocalPointArray>(nodes::topic::focal_points, 1);
  for (unsigned frame = 0; !ends; ++frame) {
    auto message = boost::make_shared<FocalPointArray>();
    message->header.stamp = ros::Time::now();
    message->header.frame_id = nodes::frame::array;
    message->modulation_frequency = static_cast<float>(modulation_frequency);
    message->points.resize(1);
    message->points[0].id = 1;
    message->points[0].position.x = 0.04 * std::sin(0.1 * frame);
    message->points[0].position.z = 0.17;
    message->points[0].intensity = 1.0f;
    message->points[0].pressure = 1000.0f;
    publisher.publish(message);
    std::this_thread::sleep_for(std::chrono::duration<double>(1.0 / frame_rate));
  }
}

void waitFor(const char* what, const std::function<bool()>& condition) {
  const auto until = Clock::now() + patience;
  while (!condition()) {
    if (Clock::now() > until || !ros::ok()) throw std::runtime_error(std::string("no ") + what);
    std::this_thread::sleep_for(1ms);
  }
}

double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

void tell(const char* what, const std::vector<double>& times) {
  std::printf("%s: median %.1f ms, 90 %% %.1f ms, 99 %% %.1f ms, longest %.1f ms\n", what,
              tools::quantile(times, 0.5), tools::quantile(times, 0.9), tools::quantile(times, 0.99),
              tools::quantile(times, 1.0));
}

/// Results of the stops, ms each.
struct Stops {
  std::vector<double> silence, answer;
  int failures = 0;  // stops after which the boards sounded
};

Stops stopAgainAndAgain(ros::NodeHandle& nh, const SonicSurfaceTerminal& boards, int rounds, bool by_topic) {
  Stops stops;
  auto stop_topic = nh.advertise<std_msgs::Empty>(nodes::topic::array_stop, 1);
  for (const char* service : {nodes::topic::array_stop, nodes::topic::array_reset})
    ros::service::waitForService(nh.resolveName(service), ros::Duration(20.0));
  auto stop = nh.serviceClient<std_srvs::Trigger>(nodes::topic::array_stop, true);
  auto reset = nh.serviceClient<std_srvs::Trigger>(nodes::topic::array_reset, true);
  if (by_topic) waitFor("array", [&] { return stop_topic.getNumSubscribers() > 0; });
  std::mt19937 random(1);
  std::uniform_int_distribution<int> jitter(0, 50);
  std_srvs::Trigger call;
  for (int round = 0; round < rounds; ++round) {
    waitFor("sound", [&] { return !boards.state().patterns.empty(); });
    std::this_thread::sleep_for(settled + std::chrono::milliseconds(jitter(random)));
    const auto start = Clock::now();
    if (by_topic)
      stop_topic.publish(std_msgs::Empty());
    else if (!stop.call(call))
      throw std::runtime_error("no answer to a stop");
    stops.answer.push_back(milliseconds(Clock::now() - start));
    std::this_thread::sleep_for(settled);
    const auto state = boards.state();
    if (state.sounds) ++stops.failures;
    stops.silence.push_back(std::max(0.0, milliseconds(state.sounded_until - start)));
    if (!reset.call(call)) throw std::runtime_error("no answer to a reset");
  }
  return stops;
}

int measure(const tools::Arguments& arguments, const std::string& port) {
  const auto rounds = static_cast<int>(arguments.number("rounds", 1, 1e6));
  const bool by_topic = arguments["by"] == "topic";
  ros::NodeHandle nh(space);
  const SonicSurfaceTerminal boards(port, 1, false);
  std::vector<std::string> words{programBeside("array_driver"),
                                 std::string("__ns:=") + space,
                                 "__name:=measured_array",
                                 "_device:=sonic_surface",
                                 "_port:=" + port,
                                 "_head_spl_cap:=200",
                                 "_pressure_cap:=1000000",
                                 "_device_options:=wait=10 " + arguments["device_options"]};
  const Child driver([&] {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    ::execv(argv[0], argv.data());
  });
  std::atomic<bool> ends{false};
  std::thread streaming([&] { stream(nh, arguments.number("modulation_frequency", 0.0, 1000.0), ends); });
  Stops stops;
  try {
    stops = stopAgainAndAgain(nh, boards, rounds, by_topic);
  } catch (...) {
    ends = true;
    streaming.join();
    throw;
  }
  ends = true;
  streaming.join();
  std::printf("%d stops by %s beside %s busy loops, %u processors\n", rounds, arguments["by"].c_str(),
              arguments["busy"].c_str(), std::thread::hardware_concurrency());
  if (!by_topic) tell("answer", stops.answer);
  tell("silence", stops.silence);
  if (stops.failures > 0) std::printf("FAILED: the boards sounded after %d stops\n", stops.failures);
  const double limit = milliseconds(silence_times::stop);
  if (tools::quantile(stops.silence, 0.99) > limit)
    std::printf("LATE: expected 99 %% within %.0f ms\n", limit);
  return stops.failures > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("measure_stop", usage, argc, argv, [&] {
    const tools::Arguments arguments(argc, argv,
                                     {{"rounds", "100"},
                                      {"busy", "2"},
                                      {"by", "service"},
                                      {"device_options", ""},
                                      {"modulation_frequency", "200"}});
    if (arguments["by"] != "service" && arguments["by"] != "topic")
      throw std::runtime_error("by '" + arguments["by"] + "': expected service or topic");
    // The processes are started before this process has threads.
    std::vector<Child> busy;
    const auto count = static_cast<std::size_t>(arguments.number("busy", 0, 64));
    for (std::size_t i = 0; i < count; ++i)
      busy.emplace_back([] {
        for (volatile unsigned n = 0;; n = n + 1) {
        }
      });
    int none = 1;
    ros::init(none, argv, "measure_stop", ros::init_options::AnonymousName);
    char folder[] = "/tmp/measure_stop_XXXXXX";
    if (::mkdtemp(folder) == nullptr) throw std::runtime_error("a folder in /tmp cannot be made");
    const int code = measure(arguments, std::string(folder) + "/boards");
    ::rmdir(folder);
    return code;
  });
}
