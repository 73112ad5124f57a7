// The gated array in front of an array that records its calls. Needs a master: with_master.py.
#include "nodes/gated_array.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds patience(10);
constexpr double frames_a_second = 60.0;

/// The calls that an array received, in order.
struct Told {
  bool sounds = false;  // else it was silenced
  device::Sound sound;
  ros::Time stamp;
};

class Array {
 public:
  GatedArray::Output output(bool harmless) {
    GatedArray::Output output;
    output.harmless = harmless;
    output.model = model_;
    output.scalable = true;
    output.solve = [this](const auto& points, const auto* before) { return model_.solve(points, before); };
    output.repertoire = {"written", {ultrasound::Modulation::amplitude}, 0.0, 0, true};
    output.emit = [this](const device::Sound& sound, const std_msgs::Header& header) {
      if (broken) throw std::runtime_error("the cable is out");
      add({true, sound, header.stamp});
    };
    output.show = [this](const device::Sound&, const std_msgs::Header&) {
      while (busy) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    output.silence = [this](const std_msgs::Header& header) { add({false, {}, header.stamp}); };
    output.fault = [] { return std::string(); };
    return output;
  }

  /// Waits for a call since `from` that fits.
  /// @return its index; nothing if none came
  template <typename F>
  std::optional<std::size_t> wait(std::size_t from, const F& fits) {
    std::unique_lock<std::mutex> lock(mutex_);
    std::size_t k = from;
    const bool came = came_.wait_for(lock, patience, [&] {
      while (k < told_.size() && !fits(told_[k])) ++k;
      return k < told_.size();
    });
    return came ? std::optional(k) : std::nullopt;
  }
  std::vector<Told> told() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return told_;
  }

  std::atomic<bool> broken{false}, busy{false};

 private:
  void add(const Told& told) {
    const std::lock_guard<std::mutex> lock(mutex_);
    told_.push_back(told);
    came_.notify_all();
  }

  ArrayModel model_{ros::NodeHandle("~")};
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<Told> told_;
};

/// A hand and a focal point on it, 60 times a second.
class Stream {
 public:
  Stream() : thread_([this] { run(); }) {}
  ~Stream() {
    ends_ = true;
    thread_.join();
  }

 private:
  void run() {
    ros::NodeHandle nh;
    auto points = nh.advertise<FocalPointArray>(topic::focal_points, 1);
    auto hands = nh.advertise<TrackedHands>(topic::hands_tracked, 1);
    for (ros::Rate rate(frames_a_second); !ends_; rate.sleep()) {
      TrackedHands hand;
      hand.header.stamp = ros::Time::now();
      hand.header.frame_id = frame::world;
      hand.hands.resize(1);
      for (auto& joint : hand.hands[0].joints) joint.orientation.w = 1.0;
      hand.hands[0].confidence = 1.0f;
      hands.publish(hand);
      FocalPointArray array;
      array.header.stamp = hand.header.stamp;
      array.header.frame_id = frame::array;
      array.modulation_frequency = 200.0f;
      array.points.resize(1);
      array.points[0].id = 1;
      array.points[0].position.z = 0.2;
      array.points[0].pressure = 1000.0f;
      array.points[0].intensity = 0.5f;
      points.publish(array);
    }
  }

  std::atomic<bool> ends_{false};
  std::thread thread_;
};

bool sounds(const Told& told) {
  return told.sounds && !told.sound.parts.empty();
}
bool silent(const Told& told) {
  return !told.sounds;
}

class GatedArrayTest : public testing::Test {
 protected:
  void start(bool harmless = false) {
    gated_ = std::make_unique<GatedArray>(ros::NodeHandle(), ros::NodeHandle("~"), "written", true,
                                          array_.output(harmless));
  }
  void call(const std::string& name) {
    std_srvs::Trigger trigger;
    ASSERT_TRUE(ros::service::waitForService(name, ros::Duration(10.0)));
    ASSERT_TRUE(ros::service::call(name, trigger));
    ASSERT_TRUE(trigger.response.success);
  }

  Array array_;
  std::unique_ptr<GatedArray> gated_;
};

TEST_F(GatedArrayTest, EmitsWhatTheGateReturnedAndIsSilentInTheEnd) {
  start();
  {
    const Stream stream;
    const auto first = array_.wait(0, sounds);
    ASSERT_TRUE(first);
    const Told told = array_.told()[*first];
    EXPECT_LT(std::abs((ros::Time::now() - told.stamp).toSec()), 1.0);
    ASSERT_EQ(told.sound.emission.points.size(), 1u);
    EXPECT_NEAR(told.sound.emission.points[0].position.z(), 0.2, 1e-6);
    // The slew is applied last: a new point does not begin with the wanted intensity.
    EXPECT_LT(told.sound.emission.points[0].intensity, 0.5);
    gated_.reset();
  }
  EXPECT_TRUE(silent(array_.told().back()));
}

/// Publishing what a frame shows may take long; a stop of the array does not wait for it.
TEST_F(GatedArrayTest, AStopDoesNotWaitForABusyCallback) {
  start();
  const Stream stream;
  ASSERT_TRUE(array_.wait(0, sounds));
  array_.busy = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the callback hangs
  const std::size_t before = array_.told().size();
  call(topic::array_stop);
  const std::vector<Told> told = array_.told();  // when the service has answered, it is silent
  ASSERT_GT(told.size(), before);
  EXPECT_TRUE(silent(told.back()));
  array_.busy = false;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const std::vector<Told> stopped = array_.told();
  for (std::size_t k = before; k < stopped.size(); ++k) EXPECT_FALSE(sounds(stopped[k])) << k;
  call(topic::array_reset);
  EXPECT_TRUE(array_.wait(stopped.size(), sounds));
}

TEST_F(GatedArrayTest, AnArrayThatThrowsIsSilencedAndComesBack) {
  start();
  const Stream stream;
  ASSERT_TRUE(array_.wait(0, sounds));
  array_.broken = true;
  const auto silenced = array_.wait(array_.told().size(), silent);
  ASSERT_TRUE(silenced);
  array_.broken = false;
  EXPECT_TRUE(array_.wait(*silenced, sounds));
}

/// A name of a frame may contain anything, also lines that look like those of the log.
TEST_F(GatedArrayTest, TheReasonIsOneLine) {
  start();
  ros::NodeHandle nh;
  std::mutex mutex;
  std::string reason;
  const auto heard = nh.subscribe<ArrayState>(topic::array_state, 10, [&](const ArrayState::ConstPtr& state) {
    const std::lock_guard<std::mutex> lock(mutex);
    reason = state->silent_reason;
  });
  auto points = nh.advertise<FocalPointArray>(topic::focal_points, 1);
  const auto told = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return reason.find("focal points in frame") != std::string::npos;
  };
  for (const auto end = Clock::now() + patience; !told() && Clock::now() < end;) {
    FocalPointArray array;
    array.header.stamp = ros::Time::now();
    array.header.frame_id = "here\n[FATAL] there";
    points.publish(array);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::lock_guard<std::mutex> lock(mutex);
  EXPECT_EQ(reason, "focal points in frame 'here?[FATAL] there', expected 'array'");
}

TEST_F(GatedArrayTest, IsSilentSoonAfterTheLastFrame) {
  start();
  {
    const Stream stream;
    ASSERT_TRUE(array_.wait(0, sounds));
  }
  const Clock::time_point ended = Clock::now();
  ASSERT_TRUE(array_.wait(array_.told().size(), silent));
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - ended).count(), 0.5);
}

TEST_F(GatedArrayTest, WhatIsRealKeepsAllItsRules) {
  ros::param::set("~gate_without", std::vector<std::string>{"slew"});
  std::string line;
  try {
    start();
  } catch (const std::runtime_error& error) {
    line = error.what();
  }
  EXPECT_NE(line.find("gate_without"), std::string::npos) << line;
  EXPECT_NO_THROW(start(true));
  ros::param::del("~gate_without");
}

}  // namespace
}  // namespace tactile_clay::nodes

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "gated_array_test");
  const ros::NodeHandle stays;
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
