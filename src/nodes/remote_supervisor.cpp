#include "nodes/remote_supervisor.h"

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <stdexcept>
#include <utility>

#include "safety/silence_times.h"

namespace tactile_clay::nodes {
namespace {

using XmlRpc::XmlRpcValue;

constexpr double look = 0.02;  // s, between two checks whether to give up

enum class Answer { none, yes, refused };

/// A client of its own, because ROS's own calls wait for a master for ever.
class Client : public XmlRpc::XmlRpcClient {
 public:
  Client(const std::string& host, int port) : XmlRpcClient(host.c_str(), port, "/") { setKeepOpen(true); }

  /// @param ends whether to give up
  template <class Ends>
  Answer ask(const RemoteSupervisor::Question& question, const Ends& ends) {
    XmlRpcValue answer;
    if (!executeNonBlock(question.method.c_str(), question.arguments)) return Answer::none;
    while (_connectionState != IDLE && _connectionState != NO_CONNECTION) {
      if (ends()) {
        close();
        return Answer::none;
      }
      _disp.work(look);
    }
    if (!executeCheckDone(answer)) return Answer::none;
    // An answer has the form [code, words, value]; code 1 means success. An answer that is cut off does not
    // count.
    if (isFault() || answer.getType() != XmlRpcValue::TypeArray || answer.size() != 3 ||
        answer[0].getType() != XmlRpcValue::TypeInt)
      return Answer::none;
    if (static_cast<int>(answer[0]) != 1) return Answer::refused;
    const bool as_expected =
        question.value.empty() || (answer[2].getType() == XmlRpcValue::TypeString &&
                                   static_cast<std::string>(answer[2]) == question.value);
    return as_expected ? Answer::yes : Answer::refused;
  }
};

}  // namespace

std::unique_ptr<RemoteSupervisor> RemoteSupervisor::master() {
  Question question;
  question.method = "lookupNode";
  question.arguments[0] = question.arguments[1] = ros::this_node::getName();
  // A new master may know another node of this name.
  question.value = ros::XMLRPCManager::instance()->getServerURI();
  question.refused =
      "does not know this node any more, because the master was started again: start the rig again";
  return std::make_unique<RemoteSupervisor>("the master", ros::master::getURI(), question);
}

std::unique_ptr<RemoteSupervisor> RemoteSupervisor::roslaunch(const std::string& address) {
  Question question;
  question.method = "get_pid";
  return std::make_unique<RemoteSupervisor>("roslaunch", address, question);
}

RemoteSupervisor::RemoteSupervisor(std::string name, std::string address, Question question)
    : name_(std::move(name)), address_(std::move(address)), question_(std::move(question)) {
  thread_ = std::thread([this] { run(); });
}

RemoteSupervisor::~RemoteSupervisor() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void RemoteSupervisor::run() {
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(address_, host, port);
  Client client(host, static_cast<int>(port));
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ending_) {
    lock.unlock();
    const auto asked = Clock::now();
    const Answer answer = client.ask(question_, [&] {
      const std::lock_guard<std::mutex> look_at(mutex_);
      // A server that was frozen may have lost the question.
      return ending_ || Clock::now() - asked > silence_times::supervisor_patience;
    });
    lock.lock();
    if (answer != Answer::none) {
      answered_ = Clock::now();
      refused_ = answer == Answer::refused;
    }
    changed_.wait_for(lock, silence_times::supervisor_beat, [this] { return ending_; });
  }
}

std::string RemoteSupervisor::missing() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::string who = name_ + " at " + address_ + " ";
  if (Clock::now() - answered_ > silence_times::supervisor_patience)
    return who + "has not answered for " + std::to_string(silence_times::supervisor_patience.count()) +
           " ms: it is dead, frozen, or cut off";
  return refused_ && !question_.refused.empty() ? who + question_.refused : "";
}

}  // namespace tactile_clay::nodes
