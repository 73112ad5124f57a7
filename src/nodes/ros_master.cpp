#include "nodes/ros_master.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcDispatch.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <memory>
#include <thread>

namespace tactile_clay::nodes {
namespace {

using std::chrono::steady_clock;
using XmlRpc::XmlRpcValue;

constexpr std::chrono::milliseconds patience(2000);
constexpr std::chrono::milliseconds step(50);

/// Whether a process accepts connections there; a frozen process does, too.
bool listens(const Address& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found) != 0)
    return false;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> keep(found, &::freeaddrinfo);
  bool open = false;
  for (const addrinfo* one = found; one != nullptr && !open; one = one->ai_next) {
    const int fd =
        ::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, one->ai_protocol);
    if (fd < 0) continue;
    open = ::connect(fd, one->ai_addr, one->ai_addrlen) == 0;
    pollfd wait = {fd, POLLOUT, 0};
    if (!open && errno == EINPROGRESS && ::poll(&wait, 1, static_cast<int>(patience.count())) == 1) {
      int error = 0;
      socklen_t size = sizeof error;
      open = ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
    }
    ::close(fd);
  }
  return open;
}

}  // namespace

std::optional<Address> addressOf(const std::string& uri) {
  const std::string scheme = "http://";
  if (uri.rfind(scheme, 0) != 0) return std::nullopt;
  const std::size_t end = std::min(uri.find('/', scheme.size()), uri.size());
  const std::size_t colon = uri.rfind(':', end);
  if (colon == std::string::npos || colon < scheme.size()) return std::nullopt;
  Address address;
  address.host = uri.substr(scheme.size(), colon - scheme.size());
  const auto [rest, error] = std::from_chars(uri.data() + colon + 1, uri.data() + end, address.port);
  if (error != std::errc() || rest != uri.data() + end || address.host.empty()) return std::nullopt;
  return address;
}

std::optional<XmlRpcValue> ask(const Address& address, const std::string& method,
                               const std::vector<std::string>& arguments) {
  XmlRpcValue request, response;
  request[0] = "/tactile_clay";
  for (std::size_t i = 0; i < arguments.size(); ++i) request[static_cast<int>(i) + 1] = arguments[i];
  if (!listens(address)) return std::nullopt;
  XmlRpc::XmlRpcClient client(address.host.c_str(), address.port, "/");
  if (!client.executeNonBlock(method.c_str(), request)) return std::nullopt;
  XmlRpc::XmlRpcDispatch dispatch;
  dispatch.addSource(&client, XmlRpc::XmlRpcDispatch::WritableEvent | XmlRpc::XmlRpcDispatch::Exception);
  bool done = false;
  for (const auto deadline = steady_clock::now() + patience; !done && steady_clock::now() < deadline;) {
    dispatch.work(std::chrono::duration<double>(step).count());
    done = client.executeCheckDone(response);
    // The dispatcher does not wait once the other side is gone.
    if (!done) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  dispatch.removeSource(&client);
  // [1, words, value] if the call succeeded
  if (!done || client.isFault() || response.getType() != XmlRpcValue::TypeArray || response.size() != 3 ||
      response[0].getType() != XmlRpcValue::TypeInt || static_cast<int>(response[0]) != 1)
    return std::nullopt;
  return response[2];
}

std::vector<RunningNode> running(const Address& master, const std::vector<std::string>& names) {
  std::vector<RunningNode> nodes;
  for (const std::string& name : names) {
    auto uri = ask(master, "lookupNode", {name});
    if (!uri || uri->getType() != XmlRpcValue::TypeString) continue;
    const auto address = addressOf(static_cast<std::string>(*uri));
    if (!address || !listens(*address)) continue;
    auto process = ask(*address, "getPid");
    const bool told = process && process->getType() == XmlRpcValue::TypeInt;
    nodes.push_back({name, name +
                               (told ? " (process " + std::to_string(static_cast<int>(*process)) + " on "
                                     : " (frozen, on ") +
                               address->host + ")"});
  }
  return nodes;
}

std::vector<RunningNode> runningForGood(const Address& master, const std::vector<std::string>& names) {
  std::vector<RunningNode> nodes;
  for (const auto deadline = steady_clock::now() + patience;;) {
    nodes = running(master, names);
    if (nodes.empty() || steady_clock::now() > deadline) return nodes;
    std::this_thread::sleep_for(2 * step);
  }
}

}  // namespace tactile_clay::nodes
