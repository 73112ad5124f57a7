#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hand/hand_source.h"

namespace tactile_clay::hand {

/// Where a websocket tracker listens.
struct WebsocketUrl {
  std::string host = "localhost";
  std::string port = "6437";
  std::string path = "/v6.json";

  std::string text() const { return "ws://" + host + ":" + port + path; }
};

/// Reads "ws://HOST[:PORT][/PATH]", also without "ws://"; what is missing, or all of an empty text, is what
/// Ultraleap's server and the Leap service use.
/// @throws std::runtime_error with one line
WebsocketUrl parseWebsocketUrl(const std::string& text);

/// A live tracker that speaks Leap's JSON protocol v6 over a websocket: Ultraleap's
/// `UltraleapTrackingWebSocket` or the older Leap service. A thread of its own keeps the connection, makes it
/// anew 0.5 s after it broke, and keeps the newest frame only, so that a slow reader gets no old hands. What
/// is no message of the protocol is left out and told by takeFault().
class LeapWebsocket : public HandSource {
 public:
  LeapWebsocket();
  /// Says goodbye to the server; takes at most 0.3 s.
  ~LeapWebsocket() override;

  /// Starts to connect; a server that is not there yet is no error.
  /// @throws std::runtime_error if `options.url` is none
  void open(const SourceOptions& options) override;
  Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) override;
  bool recorded() const override { return false; }
  std::string takeFault() override;

  /// Since open.
  struct Counts {
    std::uint64_t connections = 0;
    std::uint64_t frames = 0;      // that arrived whole
    std::uint64_t superseded = 0;  // of these, replaced by a newer one before they were read
    std::uint64_t garbage = 0;     // messages that were none, hands that could not be used
  };
  Counts counts() const;

 private:
  class Client;
  std::unique_ptr<Client> client_;
};

}  // namespace tactile_clay::hand
