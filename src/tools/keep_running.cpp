#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "nodes/kept.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] =
    R"(Runs a program as a node. Starts it again if it was killed, has crashed, or is frozen.

  keep_running [--again] [--patience S] PROGRAM ARGUMENTS...

  --again       also starts the program again if it ended with code 0 and nobody asked it to end, such as a nodelet
                without its manager
  --patience S  time without a sign of life after which the program counts as frozen, s            [5]

A program that ends by itself is not started again: keep_running exits with its exit code. A program that was killed
or frozen is not started again if the process that started keep_running is gone, or after 5 starts within a minute:
keep_running exits with 128 + signal. rig.launch runs each program of a live run with it (launch-prefix).
)";

namespace nodes = tactile_clay::nodes;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr std::size_t max_starts = 5;  // restarts within `of_late`
constexpr Seconds of_late(60.0);
constexpr Seconds look(0.1);              // between two looks at the program
constexpr Seconds stopped_patience(1.0);  // for a program that is stopped (SIGSTOP), which cannot be busy
constexpr Seconds ending_patience(60.0);  // longer than the time after which roslaunch kills

struct Options {
  bool again = false;
  Seconds patience{5.0};
  std::vector<char*> command;  // ends with a null pointer
  std::string name, log_folder;
};

Options optionsOf(int argc, char** argv) {
  Options options;
  int k = 1;
  for (; k < argc && std::strncmp(argv[k], "--", 2) == 0; ++k) {
    if (argv[k] == std::string("--again"))
      options.again = true;
    else if (argv[k] == std::string("--patience") && k + 1 < argc)
      options.patience = Seconds(tactile_clay::tools::numberOf("--patience", argv[++k], 0.1, 3600.0));
    else
      throw std::runtime_error("unknown option '" + std::string(argv[k]) + "', see --help");
  }
  if (k == argc) throw std::runtime_error("expected a program, see --help");
  options.name = std::filesystem::path(argv[k]).filename().string();
  for (int i = k; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("__name:=", 0) == 0) options.name = argument.substr(std::strlen("__name:="));
    if (argument.rfind("__log:=", 0) == 0)
      options.log_folder = std::filesystem::path(argument.substr(std::strlen("__log:="))).parent_path();
    options.command.push_back(argv[i]);
  }
  options.command.push_back(nullptr);
  return options;
}

/// A folder in which the program saves what it needs after a restart. The keeper removes it at its end.
class Folder {
 public:
  /// @param beside folder of the run; if it is empty or cannot be written to, the folder for temporary files
  Folder(const std::string& beside, const std::string& name) {
    std::error_code ignored;
    for (const std::filesystem::path& parent :
         {std::filesystem::path(beside), std::filesystem::temp_directory_path(ignored)}) {
      std::string made = (parent / (name + ".kept.XXXXXX")).string();
      if (parent.empty() || ::mkdtemp(&made[0]) == nullptr) continue;
      path_ = made;
      return;
    }
    throw std::runtime_error("the folder for the files of " + name +
                             " cannot be made: " + std::strerror(errno));
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void say(const std::string& line) {
  std::fprintf(stderr, "tactile_clay: %s\n", line.c_str());
}

/// Receives the signals of this process one after the other, so that they do not interrupt it.
class Signals {
 public:
  Signals() {
    std::signal(SIGCHLD, SIG_DFL);  // the parent process may have ignored it
    ::sigemptyset(&set_);
    for (const int number : {SIGCHLD, SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&set_, number);
    ::sigprocmask(SIG_BLOCK, &set_, &before_);
  }
  /// @return the number of a signal; 0 if none comes within `look`
  int wait() const {
    const timespec time{0, static_cast<long>(1e9 * look.count())};
    return std::max(::sigtimedwait(&set_, nullptr, &time), 0);
  }
  /// Lets signals through again, in the process of the program.
  void letThrough() const { ::sigprocmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t set_{}, before_{};
};

/// The program, once started.
class Program {
 public:
  Program(const Options& options, const Signals& signals, const std::string& folder)
      : patience_(options.patience) {
    int ends[2];
    if (::pipe2(ends, O_NONBLOCK | O_CLOEXEC) != 0) fail("a pipe cannot be made");
    beats_ = ends[0];
    process_ = ::fork();
    if (process_ < 0) fail("a process cannot be started");
    if (process_ == 0) {
      signals.letThrough();
      // If the keeper dies, nobody could end or restart the program: so it ends, too.
      ::prctl(PR_SET_PDEATHSIG, SIGTERM);
      ::fcntl(ends[1], F_SETFD, 0);
      ::setenv(nodes::beat_variable, std::to_string(ends[1]).c_str(), 1);
      ::setenv(nodes::folder_variable, folder.c_str(), 1);
      ::execvp(options.command[0], options.command.data());
      std::fprintf(stderr, "tactile_clay: %s cannot be started: %s\n", options.command[0],
                   std::strerror(errno));
      ::_exit(1);
    }
    ::close(ends[1]);
  }
  ~Program() { ::close(beats_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// @return whether it has ended; `status` is then that of waitpid
  bool hasEnded(int& status) {
    while (true) {
      const pid_t changed = ::waitpid(process_, &status, WNOHANG | WUNTRACED | WCONTINUED);
      if (changed <= 0) return false;
      if (WIFEXITED(status) || WIFSIGNALED(status)) return true;
      stopped_ = WIFSTOPPED(status);
      quiet_ = Seconds(0.0);
    }
  }

  /// @param awake time since the last call in which this process was awake
  bool isFrozen(Seconds awake) {
    char beats[256];
    bool beat = false;
    while (::read(beats_, beats, sizeof beats) > 0) beat = true;
    begun_ |= beat;
    quiet_ = beat ? Seconds(0.0) : quiet_ + awake;
    return quiet_ > (stopped_ ? stopped_patience : patience_) && (stopped_ || begun_);
  }

  void send(int number) const { ::kill(process_, number); }

 private:
  [[noreturn]] static void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
  }

  Seconds patience_;
  int beats_ = -1;
  pid_t process_ = -1;
  bool begun_ = false;    // whether it has given a sign of life
  bool stopped_ = false;  // by SIGSTOP, for instance
  Seconds quiet_{0.0};
};

/// How a start of the program ended.
struct End {
  int status = 0;  // of waitpid
  bool frozen = false;
  bool asked = false;  // whether it was asked to end

  int code() const { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }
  std::string words() const {
    if (frozen) return "was frozen";
    if (WIFEXITED(status)) return "ended although nobody asked it to";
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) +
           ")";
  }
};

End runOnce(const Options& options, const Signals& signals, const std::string& folder) {
  Program program(options, signals, folder);
  End end;
  Clock::time_point before = Clock::now();
  Seconds asked_for(0.0);
  while (!program.hasEnded(end.status)) {
    const int number = signals.wait();
    const Clock::time_point now = Clock::now();
    // While this process itself was frozen, it could not hear the program.
    const Seconds awake = std::min<Seconds>(now - before, 2.0 * look);
    before = now;
    if (number != 0 && number != SIGCHLD) {
      end.asked = true;
      program.send(number);
      program.send(SIGCONT);  // a stopped program would not end
    }
    if (end.asked) {
      if ((asked_for += awake) > ending_patience) program.send(SIGKILL);
    } else if (program.isFrozen(awake)) {
      end.frozen = true;
      program.send(SIGKILL);
    }
  }
  return end;
}

int keep(const Options& options) {
  const Signals signals;
  const Folder folder(options.log_folder, options.name);
  const pid_t parent = ::getppid();
  std::deque<Clock::time_point> starts;
  while (true) {
    const End end = runOnce(options, signals, folder.path());
    const bool wanted = !WIFEXITED(end.status) || (options.again && end.code() == 0);
    if (end.asked || !wanted) return end.code();
    if (::getppid() != parent) {
      say(options.name + " " + end.words() +
          ", and is not started again: the process that started keep_running is gone");
      return end.code();
    }
    const Clock::time_point now = Clock::now();
    while (!starts.empty() && now - starts.front() > of_late) starts.pop_front();
    if (starts.size() == max_starts) {
      say(options.name + " " + end.words() + " for the " + std::to_string(max_starts + 1) +
          "th time within a minute, and is not started again");
      return std::max(end.code(), 1);
    }
    starts.push_back(now);
    say(options.name + " " + end.words() + ", and is started again");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && tactile_clay::tools::askedForHelp(argc, argv, usage)) return 0;
  try {
    return keep(optionsOf(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "keep_running: %s\n", error.what());
    return 1;
  }
}
