#include "clay/thread_team.h"

#include <algorithm>
#include <chrono>

namespace tactile_clay::clay {
namespace {

// About the time that sleeping and waking take.
constexpr std::chrono::microseconds spin_time(20);

thread_local ThreadTeam* current_team = nullptr;

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// @return whether done() became true within `spin_time`
template <typename F>
bool comesSoon(const F& done) {
  const auto end = std::chrono::steady_clock::now() + spin_time;
  do {
    for (int k = 0; k < 16; ++k) {
      if (done()) return true;
      pause();
    }
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

}  // namespace

ThreadTeam::Lend::Lend(ThreadTeam* team) : before(current_team) {
  current_team = team;
}
ThreadTeam::Lend::~Lend() {
  current_team = before;
}
ThreadTeam* ThreadTeam::current() {
  return current_team;
}

// No call is missed. The sleeper writes `taken` before it reads the condition, and the waker writes the
// condition before it reads `taken`; all threads see these writes in one order. So either the sleeper sees
// that the condition is true, or the waker sees that the bed is taken.
template <typename F>
void ThreadTeam::Bed::sleepUntil(const F& done) {
  std::unique_lock<std::mutex> lock(mutex);
  taken = true;
  called.wait(lock, done);
  taken = false;
}
void ThreadTeam::Bed::wake() {
  if (!taken) return;
  { const std::lock_guard<std::mutex> lock(mutex); }
  called.notify_one();
}

ThreadTeam::ThreadTeam(int threads) {
  if (threads <= 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  for (int k = 1; k < threads; ++k) workers_.push_back(std::make_unique<Worker>());
  for (std::uint32_t k = 1; k < size(); ++k) workers_[k - 1]->thread = std::thread([this, k] { work(k); });
}

ThreadTeam::~ThreadTeam() {
  stop_ = true;
  for (auto& worker : workers_) worker->bed.wake();
  for (auto& worker : workers_) worker->thread.join();
}

void ThreadTeam::begin(std::uint32_t wanted, Call call, const void* job) {
  call_ = call;
  job_ = job;
  state_ = ((state_ & number) + (open << 1u)) | open;
  for (std::uint32_t k = 1; k < std::min(wanted, size()); ++k) workers_[k - 1]->bed.wake();
}

void ThreadTeam::end() {
  state_ &= ~open;
  const auto all_left = [this] { return (state_ & inside) == 0; };
  if (!comesSoon(all_left)) bed_.sleepUntil(all_left);
}

void ThreadTeam::work(std::uint32_t k) {
  std::uint64_t seen = 0;
  for (;;) {
    const auto called = [&] { return (state_ & number) != seen || stop_; };
    if (!comesSoon(called)) workers_[k - 1]->bed.sleepUntil(called);
    if (stop_) return;
    std::uint64_t state = state_;
    seen = state & number;
    bool joined = false;
    while (!joined && (state & number) == seen && (state & open) != 0)
      joined = state_.compare_exchange_weak(state, state + 1);
    if (!joined) continue;
    call_(job_, k);
    if (((--state_) & (open | inside)) == 0) bed_.wake();
  }
}

}  // namespace tactile_clay::clay
