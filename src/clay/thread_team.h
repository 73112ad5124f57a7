#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace tactile_clay::clay {

/// Threads that run one function at a time together with the thread that asks for it. Who waits looks for
/// 20 us whether there is something to do, then sleeps; nobody yields. TBB's threads yield while they wait,
/// which gives a whole time slice to whatever else runs on their core: beside other nodes that costs a frame
/// more than its work (doc/logbook/performance.md).
class ThreadTeam {
 public:
  /// @param threads with the one that asks; 0: as many as there are cores
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  std::uint32_t size() const { return static_cast<std::uint32_t>(workers_.size()) + 1; }

  /// Calls f() with this team as that of the calling thread, see `current`.
  template <typename F>
  void execute(const F& f) {
    const Lend lend(this);
    f();
  }
  /// The team of the calling thread; null: it works alone, as within `run`.
  static ThreadTeam* current();

  /// Calls f(0) here and f(k), k < size(), in the others that come before it returns; returns when all have.
  /// f must not throw.
  /// @param wanted threads that are worth waking, with this one
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
  /// Makes a team that of this thread as long as it lives.
  struct Lend {
    explicit Lend(ThreadTeam* team);
    ~Lend();
    ThreadTeam* before;
  };
  /// Where one thread sleeps.
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

  // Of the job: its number in the upper half, whether it may be joined, and how many workers have.
  static constexpr std::uint64_t number = ~std::uint64_t{0} << 32u, open = 1u << 31u, inside = open - 1;
  alignas(64) std::atomic<std::uint64_t> state_{0};
  Call call_ = nullptr;
  const void* job_ = nullptr;
  std::atomic<bool> stop_{false};
  Bed bed_;  // of the thread that asks
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace tactile_clay::clay
