// Tested against test/support/leap_server.py, an independent websocket server, over loopback.
#include "hand/leap_websocket.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "support/scratch_folder.h"

namespace tactile_clay::hand::leap_websocket_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;
using Read = HandSource::Read;

constexpr auto patience = 10s;

/// The server as a child process, and its output.
class Server {
 public:
  explicit Server(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"python3", TACTILE_CLAY_SOURCE_DIR "/test/support/leap_server.py"});
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    child_ = fork();
    if (child_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      close(ends[0]);
      close(ends[1]);
      std::vector<char*> argv;
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      execvp("python3", argv.data());
      _exit(127);
    }
    close(ends[1]);
    reader_ = std::thread([this, file = fdopen(ends[0], "r")] {
      char* line = nullptr;
      std::size_t capacity = 0;
      while (getline(&line, &capacity, file) > 0) {
        const std::lock_guard<std::mutex> lock(mutex_);
        said_.push_back(json::parse(line));
      }
      free(line);
      fclose(file);
    });
    port_ = std::to_string(waitFor("port", 1).at(0).get<int>());
  }
  ~Server() { stop(); }

  void stop() {
    if (child_ <= 0) return;
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
    child_ = -1;
    reader_.join();
  }

  const std::string& port() const { return port_; }
  SourceOptions options() const {
    SourceOptions options;
    options.url = "ws://127.0.0.1:" + port_ + "/v6.json";
    return options;
  }

  /// Its outputs under this key, as soon as there are `count` of them.
  std::vector<json> waitFor(const std::string& key, std::size_t count) const {
    const auto deadline = Clock::now() + patience;
    std::vector<json> found;
    do {
      found.clear();
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        for (const json& words : said_)
          if (words.contains(key)) found.push_back(words[key]);
      }
      if (found.size() >= count) return found;
      std::this_thread::sleep_for(5ms);
    } while (Clock::now() < deadline);
    throw std::runtime_error("the server said '" + key + "' " + std::to_string(found.size()) + " times");
  }

 private:
  pid_t child_ = -1;
  std::string port_;
  mutable std::mutex mutex_;
  std::vector<json> said_;
  std::thread reader_;
};

// A right hand, flat over the tracker, with nothing but what every service sends. Ids skip.
json bareFrame(int number) {
  json frame = {{"id", 100 + 3 * number}, {"timestamp", 5'000'000 + 10'000LL * number}};
  frame["hands"] = json::array({{{"id", 7},
                                 {"palmPosition", {0.1 * number, 150, 0}},
                                 {"palmNormal", {0, -1, 0}},
                                 {"direction", {0, 0, -1}}}});
  frame["pointables"] = json::array();
  for (int finger = 0; finger < 5; ++finger) {
    const double x = -40.0 + 20.0 * finger + 0.1 * number;
    frame["pointables"].push_back({{"id", 70 + finger},
                                   {"handId", 7},
                                   {"mcpPosition", {x, 150, -20}},
                                   {"pipPosition", {x, 150, -60}},
                                   {"dipPosition", {x, 150, -80}}});
  }
  return frame;
}

class LeapWebsocketTest : public ScratchFolder {
 protected:
  std::string frames(int count) const {
    std::string lines;
    for (int i = 0; i < count; ++i) lines += bareFrame(i).dump() + "\n";
    return write("frames.ndjson", lines);
  }

  /// Reads until the frame of this number came.
  /// @return stamps in the order of their arrival, in frames
  static std::vector<long> readUntil(LeapWebsocket& source, long last) {
    std::vector<long> numbers;
    const auto deadline = Clock::now() + patience;
    while ((numbers.empty() || numbers.back() < last) && Clock::now() < deadline) {
      TrackedFrame frame;
      if (source.read(frame, 50ms) != Read::frame) continue;
      EXPECT_EQ(frame.frame_id, "tracker");
      EXPECT_LT(std::chrono::abs(Clock::now() - frame.received), 2s);
      EXPECT_EQ(frame.hands.size(), 1U);
      numbers.push_back((frame.stamp.count() / 1000 - 5'000'000) / 10'000);
      if (frame.hands.size() == 1) {
        EXPECT_EQ(frame.hands[0].side, Side::right);
        EXPECT_NEAR(frame.hands[0].joints[palm].position.y(), -1e-4 * static_cast<double>(numbers.back()),
                    1e-9);
      }
    }
    return numbers;
  }
};

TEST_F(LeapWebsocketTest, ReadsFramesAndGreetsAsTheServiceExpects) {
  for (const bool numeric : {false, true}) {
    Server server(numeric ? std::vector<std::string>{frames(60), "--numeric-ids"}
                          : std::vector<std::string>{frames(60)});
    LeapWebsocket source;
    source.open(server.options());
    const auto numbers = readUntil(source, 59);
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
    EXPECT_EQ(numbers.back(), 59);
    EXPECT_GT(numbers.size(), 20U);
    EXPECT_EQ(source.takeFault(), "");
    EXPECT_EQ(server.waitFor("request", 1)[0], "/v6.json");
    const std::vector<json> expected = {R"({"background":true})", R"({"optimizeHMD":false})",
                                        R"({"focused":true})"};
    EXPECT_EQ(server.waitFor("text", 3), expected);
    EXPECT_EQ(source.counts().frames, 60U);
    EXPECT_EQ(source.counts().garbage, 0U);
  }
}

TEST_F(LeapWebsocketTest, AFragmentedMessageIsOneMessageAndPingsAreAnswered) {
  Server server({frames(30), "--fragments", "7"});
  LeapWebsocket source;
  source.open(server.options());
  EXPECT_EQ(readUntil(source, 29).back(), 29);
  EXPECT_EQ(source.counts().frames, 30U);
  EXPECT_EQ(source.counts().garbage, 0U);
}

TEST_F(LeapWebsocketTest, ConnectsAgainWhenTheServiceBreaksOff) {
  Server server({frames(45), "--disconnect", "15"});
  LeapWebsocket source;
  source.open(server.options());
  EXPECT_EQ(readUntil(source, 44).back(), 44);
  EXPECT_EQ(source.counts().connections, 3U);
  EXPECT_EQ(source.counts().frames, 45U);
}

TEST_F(LeapWebsocketTest, WaitsForAServiceThatIsNotThereYet) {
  std::string port;
  {
    Server server({frames(1)});
    port = server.port();
  }
  LeapWebsocket source;
  SourceOptions options;
  options.url = "127.0.0.1:" + port;
  source.open(options);
  TrackedFrame frame;
  EXPECT_EQ(source.read(frame, 300ms), Read::nothing);
  const std::string fault = source.takeFault();
  EXPECT_NE(fault.find("ws://127.0.0.1:" + port + "/v6.json"), std::string::npos) << fault;
  EXPECT_NE(fault.find("expected a server of Leap's protocol v6"), std::string::npos) << fault;
  EXPECT_EQ(std::count(fault.begin(), fault.end(), '\n'), 0);

  Server server({frames(20), "--port", port});
  EXPECT_EQ(readUntil(source, 19).back(), 19);
  EXPECT_EQ(source.takeFault(), "");
}

TEST_F(LeapWebsocketTest, GarbageIsToldAndPassedOver) {
  Server server({frames(40), "--garbage", "10"});
  LeapWebsocket source;
  source.open(server.options());
  EXPECT_EQ(readUntil(source, 39).back(), 39);
  EXPECT_EQ(source.counts().frames, 40U);
  EXPECT_EQ(source.counts().connections, 1U);
  EXPECT_EQ(source.counts().garbage, 4 * 8U);
  const std::string fault = source.takeFault();
  EXPECT_NE(fault.find("expected one message of Leap's JSON protocol v6"), std::string::npos) << fault;
  EXPECT_EQ(source.takeFault(), "");
}

TEST_F(LeapWebsocketTest, ASlowReaderGetsTheNewestFrame) {
  Server server({frames(200), "--rate", "400"});
  LeapWebsocket source;
  source.open(server.options());
  TrackedFrame frame;
  ASSERT_EQ(source.read(frame, 5s), Read::frame);
  // Nothing is read while all the others come, and the server does not have to wait.
  EXPECT_EQ(server.waitFor("sent", 1)[0], 200);
  const auto deadline = Clock::now() + patience;
  while (source.counts().frames < 200 && Clock::now() < deadline) std::this_thread::sleep_for(5ms);
  ASSERT_EQ(source.read(frame, 0ms), Read::frame);
  EXPECT_EQ(frame.stamp, std::chrono::microseconds(5'000'000 + 199 * 10'000));
  EXPECT_EQ(source.read(frame, 0ms), Read::nothing);
  EXPECT_EQ(source.counts().superseded, 198U);
}

TEST_F(LeapWebsocketTest, AnUnpluggedTrackerIsTold) {
  Server server({frames(20), "--unplug", "20"});
  LeapWebsocket source;
  source.open(server.options());
  EXPECT_EQ(readUntil(source, 19).back(), 19);
  std::string fault;
  const auto deadline = Clock::now() + patience;
  while (fault.empty() && Clock::now() < deadline) {
    std::this_thread::sleep_for(5ms);
    fault = source.takeFault();
  }
  EXPECT_NE(fault.find("has lost its tracker LP5021"), std::string::npos) << fault;
}

TEST_F(LeapWebsocketTest, AnotherServerIsToldAndTriedAgain) {
  Server server({frames(1), "--refuse"});
  LeapWebsocket source;
  source.open(server.options());
  server.waitFor("request", 3);
  TrackedFrame frame;
  EXPECT_EQ(source.read(frame, 0ms), Read::nothing);
  EXPECT_NE(source.takeFault().find("cannot be reached"), std::string::npos);
  EXPECT_EQ(source.counts().connections, 0U);
}

TEST_F(LeapWebsocketTest, SaysGoodbyeAndLeavesAtOnce) {
  Server server({frames(400)});
  const auto leave = [](std::unique_ptr<LeapWebsocket> source) {
    const auto start = Clock::now();
    source.reset();
    return Clock::now() - start;
  };
  auto source = std::make_unique<LeapWebsocket>();
  source->open(server.options());
  readUntil(*source, 5);
  EXPECT_LT(leave(std::move(source)), 1s);
  EXPECT_EQ(server.waitFor("close", 1)[0], 1000);

  // While it waits to try again, and while nobody answers.
  server.stop();
  source = std::make_unique<LeapWebsocket>();
  source->open(server.options());
  std::this_thread::sleep_for(100ms);
  EXPECT_LT(leave(std::move(source)), 1s);
  EXPECT_LT(leave(std::make_unique<LeapWebsocket>()), 1s);
}

}  // namespace
}  // namespace tactile_clay::hand::leap_websocket_test
