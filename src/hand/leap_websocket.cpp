#include "hand/leap_websocket.h"

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <regex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "hand/leap_frame.h"
#include "hand/leap_json.h"

namespace tactile_clay::hand {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using namespace std::chrono_literals;

constexpr auto back_off = 500ms;       // between a broken connection and the next try
constexpr auto connect_patience = 3s;  // for TCP and the handshake each
constexpr auto silence_patience = 4s;  // without a frame or the answer to a ping
constexpr auto goodbye_patience = 300ms;
constexpr std::size_t longest_message = leap::Limits().bytes;

// The server compares whole messages, so each one is sent alone and without a space.
constexpr std::array<const char*, 3> greetings = {R"({"background":true})", R"({"optimizeHMD":false})",
                                                  R"({"focused":true})"};

// One connection, with all that its pending operations need until they end.
struct Session {
  explicit Session(asio::io_context& io) : stream(io) {}

  websocket::stream<beast::tcp_stream> stream;
  beast::flat_buffer buffer;
};
using SessionPtr = std::shared_ptr<Session>;

}  // namespace

WebsocketUrl parseWebsocketUrl(const std::string& text) {
  static const std::regex form(
      R"((?:ws://)?([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\])(?::([0-9]{1,5}))?(/[!-~]*)?)");
  constexpr std::size_t longest = 2048;  // bytes; std::regex takes stack for each
  WebsocketUrl url;
  if (text.empty()) return url;
  if (text.size() > longest)
    throw std::runtime_error("url '" + text.substr(0, 40) +
                             "...' of the tracker: " + std::to_string(text.size()) +
                             " bytes, expected at most " + std::to_string(longest));
  std::smatch part;
  if (!std::regex_match(text, part, form) ||
      (part[2].matched && (std::stoi(part[2]) == 0 || std::stoi(part[2]) > 65535)))
    throw std::runtime_error("url '" + text + "' of the tracker: expected ws://HOST[:PORT][/PATH], such as " +
                             url.text());
  url.host = part[1];
  if (part[2].matched) url.port = part[2];
  if (part[3].matched) url.path = part[3];
  return url;
}

// Only the thread uses the members, except those that the mutex protects.
class LeapWebsocket::Client {
 public:
  explicit Client(WebsocketUrl url) : url_(std::move(url)), thread_([this] { run(); }) {}

  ~Client() {
    asio::post(io_, [this] { sayGoodbye(); });
    thread_.join();
  }

  Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!came_.wait_for(lock, timeout, [this] { return newest_.has_value(); })) return Read::nothing;
    frame = std::move(*newest_);
    newest_.reset();
    return Read::frame;
  }

  std::string takeFault() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::string fault = std::exchange(message_fault_, {});
    return connection_fault_.empty() ? fault : connection_fault_;
  }

  Counts counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
  }

 private:
  void run() {
    connection("is not connected yet");
    connect();
    io_.run();
  }

  void connect() {
    session_ = std::make_shared<Session>(io_);
    // The brackets of an IPv6 address belong to the URL.
    const bool bracketed = url_.host.front() == '[';
    resolver_.async_resolve(bracketed ? url_.host.substr(1, url_.host.size() - 2) : url_.host, url_.port,
                            [this, s = session_](error_code error, const tcp::resolver::results_type& found) {
                              if (broken(s, error)) return;
                              auto& tcp_stream = beast::get_lowest_layer(s->stream);
                              tcp_stream.expires_after(connect_patience);
                              tcp_stream.async_connect(found, [this, s](error_code e, const tcp::endpoint&) {
                                if (!broken(s, e)) shakeHands(s);
                              });
                            });
  }

  void shakeHands(const SessionPtr& s) {
    auto& tcp_stream = beast::get_lowest_layer(s->stream);
    tcp_stream.expires_never();
    error_code ignored;
    tcp_stream.socket().set_option(tcp::no_delay(true), ignored);
    s->stream.set_option(websocket::stream_base::timeout{connect_patience, silence_patience, true});
    s->stream.read_message_max(longest_message);
    s->stream.async_handshake(url_.host + ":" + url_.port, url_.path, [this, s](error_code error) {
      if (broken(s, error)) return;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        ++counts_.connections;
      }
      connection("has sent nothing yet");
      greet(s, 0);
      listen(s);
    });
  }

  void greet(const SessionPtr& s, std::size_t i) {
    if (i == greetings.size()) return;
    s->stream.text(true);
    s->stream.async_write(asio::buffer(greetings[i], std::char_traits<char>::length(greetings[i])),
                          [this, s, i](error_code error, std::size_t) {
                            if (!broken(s, error)) greet(s, i + 1);
                          });
  }

  void listen(const SessionPtr& s) {
    s->stream.async_read(s->buffer, [this, s](error_code error, std::size_t) {
      if (broken(s, error)) return;
      accept(beast::buffers_to_string(s->buffer.data()));
      s->buffer.consume(s->buffer.size());
      listen(s);
    });
  }

  void accept(const std::string& message) {
    const auto now = std::chrono::steady_clock::now();
    try {
      auto frame = parseLeapFrame(message, url_.text());
      if (frame) {
        frame->frame.received = now;
        deliver(std::move(*frame));
      } else if (const auto device = parseLeapDevice(message, url_.text())) {
        connection(!device->attached    ? "has lost its tracker " + device->id
                   : !device->streaming ? "has a tracker " + device->id + " that does not stream"
                                        : "has sent no frame yet");
      }
    } catch (const std::exception& error) {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++counts_.garbage;
      message_fault_ = error.what();
    }
  }

  void deliver(LeapFrame frame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    connection_fault_.clear();
    ++counts_.frames;
    counts_.garbage += frame.dropped.size();
    if (!frame.dropped.empty()) message_fault_ = frame.dropped.back();
    if (newest_) ++counts_.superseded;
    newest_ = std::move(frame.frame);
    came_.notify_one();
  }

  // True if the operation failed, or belongs to a session that is over.
  bool broken(const SessionPtr& s, error_code error) {
    if (s != session_) return true;
    if (!error || leaving_) return leaving_;
    session_.reset();
    connection(error == websocket::error::closed ? "has closed the connection"
                                                 : "cannot be reached: " + error.message());
    timer_.expires_after(back_off);
    timer_.async_wait([this](error_code cancelled) {
      if (!cancelled) connect();
    });
    return true;
  }

  void connection(const std::string& fault) {
    const std::lock_guard<std::mutex> lock(mutex_);
    connection_fault_ =
        "tracker at " + url_.text() + " " + fault + "; expected a server of Leap's protocol v6";
  }

  void sayGoodbye() {
    leaving_ = true;
    if (!session_ || !session_->stream.is_open()) return io_.stop();
    session_->stream.async_close(websocket::close_code::normal,
                                 [this, s = session_](error_code) { io_.stop(); });
    timer_.expires_after(goodbye_patience);
    timer_.async_wait([this](error_code) { io_.stop(); });
  }

  const WebsocketUrl url_;
  asio::io_context io_;
  tcp::resolver resolver_{io_};
  asio::steady_timer timer_{io_};
  SessionPtr session_;
  bool leaving_ = false;

  mutable std::mutex mutex_;  // protects the members below, up to counts_
  std::condition_variable came_;
  std::optional<TrackedFrame> newest_;
  std::string connection_fault_, message_fault_;
  Counts counts_;

  std::thread thread_;  // last: it uses all the others
};

LeapWebsocket::LeapWebsocket() = default;
LeapWebsocket::~LeapWebsocket() = default;

void LeapWebsocket::open(const SourceOptions& options) {
  client_ = std::make_unique<Client>(parseWebsocketUrl(options.url));
}

HandSource::Read LeapWebsocket::read(TrackedFrame& frame, std::chrono::milliseconds timeout) {
  return client_ ? client_->read(frame, timeout) : Read::ended;
}

std::string LeapWebsocket::takeFault() {
  return client_ ? client_->takeFault() : std::string();
}

LeapWebsocket::Counts LeapWebsocket::counts() const {
  return client_ ? client_->counts() : Counts();
}

}  // namespace tactile_clay::hand
