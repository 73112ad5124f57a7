#include "hand/leap_frame.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "hand/leap_hand.h"
#include "hand/leap_json.h"

namespace tactile_clay::hand {
namespace {

using leap::Json;
using leap::Pointables;

// Of a frame. Trackers see two hands; with tools each has some ten pointables.
constexpr std::size_t max_hands = 100, max_pointables = 1000;

void requireAtMost(const Json& list, std::size_t maximum, const char* what) {
  if (list.size() > maximum)
    throw std::runtime_error("has " + std::to_string(list.size()) + " " + what + ", expected at most " +
                             std::to_string(maximum));
}

Pointables sorted(const Json& pointables) {
  Pointables result;
  for (std::size_t i = 0; i < pointables.size(); ++i) {
    try {
      result.of_hand[leap::id(pointables[i], "handId")].push_back(&pointables[i]);
    } catch (const std::runtime_error& error) {
      result.fault = "pointable " + std::to_string(i) + ' ' + error.what();
    }
  }
  return result;
}

constexpr char no_bones[] =
    "its fingers have no bones, as in Leap's protocols 1 to 4, expected protocol 5 or 6";

bool haveNoBones(const Json& pointables) {
  return !pointables.empty() && std::none_of(pointables.begin(), pointables.end(), [](const Json& pointable) {
    return pointable.is_object() && pointable.contains("mcpPosition");
  });
}

std::runtime_error noLeapMessage(const std::string& where, const std::exception& error) {
  return std::runtime_error(where + ": " + error.what() +
                            ", expected one message of Leap's JSON protocol v6");
}

}  // namespace

std::optional<LeapFrame> parseLeapFrame(const std::string& text, const std::string& where) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) return std::nullopt;
  try {
    const Json message = leap::parse(text);
    if (!message.is_object()) throw std::runtime_error("is not an object");
    if (!message.contains("hands")) {
      if (message.contains("version") || message.contains("event")) return std::nullopt;
      throw std::runtime_error("has neither hands nor version nor event");
    }
    const Json& hands = leap::array(message, "hands");
    const Json& pointables = leap::array(message, "pointables");
    requireAtMost(hands, max_hands, "hands");
    requireAtMost(pointables, max_pointables, "pointables");
    LeapFrame result;
    result.frame.stamp = leap::timestamp(message);
    const Pointables by_hand = sorted(pointables);
    result.without_bones = haveNoBones(pointables);
    for (std::size_t i = 0; i < hands.size(); ++i) {
      std::string name = "hand " + std::to_string(i) + " of the frame";
      try {
        const std::string id = leap::id(hands[i], "id");
        name = "hand " + id;
        TrackedHand& hand = result.frame.hands.emplace_back(leap::readHand(hands[i], id, by_hand));
        for (UnreadJoint& joint : hand.unread) joint.why += " (" + where + ")";
      } catch (const std::runtime_error& error) {
        result.dropped.push_back(where + ": " + name +
                                 " is dropped: " + (result.without_bones ? no_bones : error.what()));
      }
    }
    return result;
  } catch (const std::exception& error) {
    throw noLeapMessage(where, error);
  }
}

std::optional<int> parseLeapVersion(const std::string& text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || message.contains("hands")) return std::nullopt;
  const auto version = message.find("version");
  if (version == message.end() || !version->is_number_integer()) return std::nullopt;
  return version->get<int>();
}

std::optional<LeapDevice> parseLeapDevice(const std::string& text, const std::string& where) {
  try {
    const Json message = leap::parse(text);
    if (!message.is_object()) throw std::runtime_error("is not an object");
    const Json& event = leap::object(message, "event");
    const auto type = event.find("type");
    if (type == event.end() || *type != "deviceEvent") return std::nullopt;
    const Json& state = leap::object(event, "state");
    return LeapDevice{leap::id(state, "id"), leap::flag(state, "attached", true),
                      leap::flag(state, "streaming", true)};
  } catch (const std::exception& error) {
    throw noLeapMessage(where, error);
  }
}

}  // namespace tactile_clay::hand
