#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace tactile_clay::clay {

/// Threads that run one function at a time, together with the thread that calls `run`. A waiting thread looks
/// for work for 20 us, then sleeps. No thread yields. TBB's threads yield while they wait, which gives a
/// whole time slice to any other program on their core: beside other nodes this costs a frame more time than
/// its work (doc/logbook/performance.md).
class ThreadTeam {
 public:
  /// @param threads including the one that calls `run`; 0: as many as there are cores
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  std::uint32_t size() const { return static_cast<std::uint32_t>(workers_.size()) + 1; }

  /// Calls f(). Meanwhile this team is the team of the calling thread, see `current`.
  template <typename F>
  void execute(const F& f) {
    const Lend lend(this);
    f();
  }
  /// The team of the calling thread. Null: the thread works alone, as it does within `run`.
  static ThreadTeam* current();

  /// Calls f(0) in this thread, and f(k), 0 < k < size(), in each other thread that joins before f(0)
  /// returns. Returns when all these calls have returned. f must not throw.
  /// @param wanted number of threads that are worth waking, including this one
  template <typename F>
  void run(std::uint32_t wanted, const F& f) {
    const Lend lend(nullptr);
    begin(
        wanted, [](const void* job, std::uint32_t k) { (*static_cast<const F*>(job))(k); }, &f);
    f(0u);
    end();
  }

 private:
  using Call = void (*)(const void* job, std::uint32_t k);
  /// Makes a team the team of this thread for as long as the object lives.
  struct Lend {
    explicit Lend(ThreadTeam* team);
    ~Lend();
    ThreadTeam* before;
  };
  /// A place where one thread sleeps until another one wakes it.
  struct Bed {
    template <typename F>
    void sleepUntil(const F& done);
    void wake();
    std::atomic<bool> taken{false};
    std::mutex mutex;
    std::condition_variable called;
  };
  struct Worker {
    Bed bed;
    std::thread thread;
  };

  void begin(std::uint32_t wanted, Call call, const void* job);
  void end();
  void work(std::uint32_t k);

  // Bits of state_: number of the job (upper half), whether workers may join it, and how many are inside.
  static constexpr std::uint64_t number = ~std::uint64_t{0} << 32u, open = 1u << 31u, inside = open - 1;
  alignas(64) std::atomic<std::uint64_t> state_{0};
  Call call_ = nullptr;
  const void* job_ = nullptr;
  std::atomic<bool> stop_{false};
  Bed bed_;  // of the thread that calls `run`
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace tactile_clay::clay
