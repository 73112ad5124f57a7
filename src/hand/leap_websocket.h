#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hand/hand_source.h"

namespace tactile_clay::hand {

/// Address at which a websocket tracker listens.
struct WebsocketUrl {
  std::string host = "localhost";
  std::string port = "6437";
  std::string path = "/v6.json";

  std::string text() const { return "ws://" + host + ":" + port + path; }
};

/// Reads "ws://HOST[:PORT][/PATH]", also without "ws://". Missing parts, or all of an empty text, are those
/// that Ultraleap's server and the Leap service use.
/// @throws std::runtime_error with one line
WebsocketUrl parseWebsocketUrl(const std::string& text);

/// A live tracker with Leap's JSON protocol v6 over a websocket: Ultraleap's `UltraleapTrackingWebSocket` or
/// the older Leap service. A separate thread keeps the connection, and makes it anew 0.5 s after it broke. It
/// keeps only the newest frame, so that a slow reader gets no old hands. A message that is not of the
/// protocol is left out and reported by takeFault().
class LeapWebsocket : public HandSource {
 public:
  LeapWebsocket();
  /// Sends a closing message to the server; takes at most 0.3 s.
  ~LeapWebsocket() override;

  /// Starts to connect. It is no error if the server is not there yet.
  /// @throws std::runtime_error if `options.url` is not a URL of this form
  void open(const SourceOptions& options) override;
  Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) override;
  bool recorded() const override { return false; }
  std::string takeFault() override;

  /// Numbers since open().
  struct Counts {
    std::uint64_t connections = 0;
    std::uint64_t frames = 0;      // frames that arrived completely
    std::uint64_t superseded = 0;  // frames that a newer one replaced before they were read
    std::uint64_t garbage = 0;     // messages not of the protocol, and unusable hands
  };
  Counts counts() const;

 private:
  class Client;
  std::unique_ptr<Client> client_;
};

}  // namespace tactile_clay::hand
