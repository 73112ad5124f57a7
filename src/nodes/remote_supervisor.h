#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "nodes/supervisors.h"

namespace tactile_clay::nodes {

/// A server of XML-RPC, a master or a roslaunch on this host or another one. It is asked the same question
/// again and again, in a thread of its own.
class RemoteSupervisor : public Supervisor {
 public:
  struct Question {
    std::string method;
    XmlRpc::XmlRpcValue arguments;
    std::string value;    // that the answer has to contain; empty: any
    std::string refused;  // meaning of an answer that is an error, or has another value; empty: none
  };

  /// The master, which also has to know this node.
  static std::unique_ptr<RemoteSupervisor> master();

  /// A roslaunch.
  /// @param address such as http://host:1234/
  static std::unique_ptr<RemoteSupervisor> roslaunch(const std::string& address);

  RemoteSupervisor(std::string name, std::string address, Question question);
  ~RemoteSupervisor() override;

  /// Reports the server as missing if no question of the last `silence_times::supervisor_patience` was
  /// answered, or if the answer is an error that has a meaning.
  std::string missing() override;

 private:
  using Clock = std::chrono::steady_clock;

  void run();

  const std::string name_, address_;
  const Question question_;

  std::mutex mutex_;  // protects the members down to `ending_`
  std::condition_variable changed_;
  Clock::time_point answered_ = Clock::now();
  bool refused_ = false;
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace tactile_clay::nodes
