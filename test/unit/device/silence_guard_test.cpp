#include "device/silence_guard.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>

namespace tactile_clay::device::silence_guard_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using State = SilenceGuard::State;

/// A pipe for a port, and a guard on it.
class SilenceGuardTest : public testing::Test {
 protected:
  static constexpr auto patience = 300ms;
  const std::vector<std::uint8_t> silence{1, 2, 3};

  void SetUp() override {
    ASSERT_EQ(::pipe2(ends_, O_CLOEXEC | O_NONBLOCK), 0);
    guard_ = std::make_unique<SilenceGuard>(ends_[1], silence, patience);
  }
  void TearDown() override {
    guard_.reset();
    ::close(ends_[0]);
    ::close(ends_[1]);
  }

  /// Whether the silence is written within this time.
  bool silenced(std::chrono::milliseconds limit) {
    pollfd state{ends_[0], POLLIN, 0};
    if (::poll(&state, 1, static_cast<int>(limit.count())) != 1) return false;
    std::vector<std::uint8_t> bytes(64);
    bytes.resize(
        static_cast<std::size_t>(std::max<ssize_t>(::read(ends_[0], bytes.data(), bytes.size()), 0)));
    return bytes == silence;
  }

  /// Sends signs of life until the guard has this state.
  /// @return how long that took
  Clock::duration beatUntil(State state) {
    const auto start = Clock::now();
    while (guard_->beat() != state && Clock::now() - start < 10s) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(guard_->beat(), state);
    return Clock::now() - start;
  }

  std::unique_ptr<SilenceGuard> guard_;

 private:
  int ends_[2];
};

TEST_F(SilenceGuardTest, SilencesAfterItsPatienceAndAgainAfterTheNextSign) {
  EXPECT_EQ(guard_->beat(), State::there);
  const auto start = Clock::now();
  EXPECT_TRUE(silenced(5s));
  EXPECT_GE(Clock::now() - start, patience - 50ms);
  EXPECT_FALSE(silenced(2 * patience)) << "once is enough";
  guard_->beat();
  EXPECT_TRUE(silenced(5s));
}

TEST_F(SilenceGuardTest, IsQuietWhileTheDriverLives) {
  const auto start = Clock::now();
  while (Clock::now() - start < 3 * patience) {
    EXPECT_EQ(guard_->beat(), State::there);
    EXPECT_FALSE(silenced(10ms));
  }
}

TEST_F(SilenceGuardTest, SilencesInTheEnd) {
  guard_->beat();
  guard_.reset();
  EXPECT_TRUE(silenced(0ms));
}

TEST_F(SilenceGuardTest, AGuardThatIsKilledIsTold) {
  guard_->beat();
  ::kill(guard_->process(), SIGKILL);
  EXPECT_LT(beatUntil(State::gone), patience);
}

TEST_F(SilenceGuardTest, AFrozenGuardIsToldUntilItGoesOn) {
  beatUntil(State::there);
  ::kill(guard_->process(), SIGSTOP);
  EXPECT_GE(beatUntil(State::frozen), patience - 50ms);
  ::kill(guard_->process(), SIGCONT);
  beatUntil(State::there);
}

TEST_F(SilenceGuardTest, AFrozenGuardHoldsNobodyUp) {
  ::kill(guard_->process(), SIGSTOP);
  beatUntil(State::frozen);
  const auto start = Clock::now();
  guard_.reset();
  EXPECT_LT(Clock::now() - start, 1s);
}

TEST_F(SilenceGuardTest, ADriverThatWasStoppedItselfDoesNotBlameTheGuard) {
  guard_->beat();
  std::this_thread::sleep_for(3 * patience);  // as if it were stopped
  EXPECT_EQ(guard_->beat(), State::there);
}

}  // namespace
}  // namespace tactile_clay::device::silence_guard_test
