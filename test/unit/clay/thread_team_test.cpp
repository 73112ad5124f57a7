#include "clay/thread_team.h"

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <numeric>
#include <thread>

#include "clay/threads.h"

namespace tactile_clay::clay::thread_team_test {
namespace {

using std::chrono::milliseconds;

double cpuSeconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

TEST(ThreadTeam, EveryRangeIsRunOnceByAnyNumberOfThreads) {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadTeam team(threads);
    ASSERT_EQ(team.size(), static_cast<std::uint32_t>(threads));
    std::vector<int> times(1000, 0);
    team.execute([&] {
      for (int k = 0; k < 2000; ++k)
        parallelFor(static_cast<std::size_t>(k) % times.size(), 16, [&](std::size_t i) { ++times[i]; });
    });
    for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], 2 * (999 - static_cast<int>(i)));
  }
}

TEST(ThreadTeam, OthersComeWhereThereIsTime) {
  ThreadTeam team(3);
  std::vector<std::thread::id> ids(3);
  std::atomic<int> come{0};
  team.run(3, [&](std::uint32_t k) {
    ids[k] = std::this_thread::get_id();
    ++come;
    while (come < 3) std::this_thread::sleep_for(milliseconds(1));
  });
  EXPECT_EQ(ids[0], std::this_thread::get_id());
  EXPECT_TRUE(ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0]);
}

TEST(ThreadTeam, IsThatOfItsCallerOnly) {
  ThreadTeam team(2);
  EXPECT_EQ(ThreadTeam::current(), nullptr);
  team.execute([&] {
    EXPECT_EQ(ThreadTeam::current(), &team);
    std::thread([] { EXPECT_EQ(ThreadTeam::current(), nullptr); }).join();
    // Loops within a loop have one thread.
    team.run(2, [](std::uint32_t) { EXPECT_EQ(ThreadTeam::current(), nullptr); });
    EXPECT_EQ(ThreadTeam::current(), &team);
  });
  EXPECT_EQ(ThreadTeam::current(), nullptr);
}

/// Both sleep while the other one works for longer than a thread waits without sleeping.
TEST(ThreadTeam, WhoWaitsSleeps) {
  ThreadTeam team(2);
  for (const std::uint32_t late : {0u, 1u}) {
    std::atomic<bool> come{false};
    const double before = cpuSeconds(CLOCK_PROCESS_CPUTIME_ID);
    std::atomic<bool> done{false};
    team.run(2, [&](std::uint32_t k) {
      if (k == 1) come = true;
      while (!come) std::this_thread::sleep_for(milliseconds(1));
      if (k != late) return;
      std::this_thread::sleep_for(milliseconds(200));
      done = true;
    });
    EXPECT_TRUE(done);
    EXPECT_LT(cpuSeconds(CLOCK_PROCESS_CPUTIME_ID) - before, 0.05);
  }
  const double before = cpuSeconds(CLOCK_PROCESS_CPUTIME_ID);
  std::this_thread::sleep_for(milliseconds(200));
  EXPECT_LT(cpuSeconds(CLOCK_PROCESS_CPUTIME_ID) - before, 0.05);
}

/// Jobs that come when the others are about to sleep, or sleep.
TEST(ThreadTeam, NobodyIsLeftAsleep) {
  ThreadTeam team(2);
  std::vector<int> numbers(64, 0);
  team.execute([&] {
    for (int k = 0; k < 2000; ++k) {
      const auto until = std::chrono::steady_clock::now() + std::chrono::microseconds(k % 60);
      while (std::chrono::steady_clock::now() < until) {
      }
      parallelFor(numbers.size(), 1, [&](std::size_t i) { ++numbers[i]; });
    }
  });
  EXPECT_EQ(std::accumulate(numbers.begin(), numbers.end(), 0), 2000 * 64);
}

TEST(ThreadTeam, TeamsWorkBesideEachOther) {
  std::vector<std::thread> callers;
  std::vector<long> sums(4, 0);
  for (long& sum : sums) {
    callers.emplace_back([&sum] {
      ThreadTeam team(2);
      std::vector<long> numbers(500, 0);
      team.execute([&] {
        for (int k = 0; k < 500; ++k)
          parallelFor(numbers.size(), 32, [&](std::size_t i) { numbers[i] += static_cast<long>(i); });
      });
      sum = std::accumulate(numbers.begin(), numbers.end(), 0L);
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (const long sum : sums) EXPECT_EQ(sum, 500L * 499 * 500 / 2);
}

}  // namespace
}  // namespace tactile_clay::clay::thread_team_test
