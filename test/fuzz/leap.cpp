// Leap JSON: one message of the websocket, or a line of a recording.
#include <cstdlib>
#include <stdexcept>

#include "fuzz/fuzz.h"
#include "hand/hand_check.h"
#include "hand/leap_frame.h"
#include "support/leap_message.h"

namespace tactile_clay::fuzz {

std::vector<std::string> seeds() {
  return {hand::leapMessage(hand::knownHand(hand::Side::left)).dump(),
          hand::leapMessage(hand::knownHand(hand::Side::right), "7").dump(),
          R"({"serviceVersion": "2.3.1", "version": 6})",
          R"({"event": {"type": "deviceEvent", "state": {"id": "1", "attached": true, "streaming": true}}})"};
}

}  // namespace tactile_clay::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile_clay;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    auto frame = hand::parseLeapFrame(text, "fuzz:1");
    hand::parseLeapVersion(text);
    hand::parseLeapDevice(text, "fuzz:1");
    if (!frame) return 0;
    for (const std::string& line : frame->dropped) fuzz::expectOneLine(line);
    // Single numbers that are none are for `judge`, as of any source.
    for (const std::string& line : hand::leaveOutBadHands(frame->frame.hands).lines)
      fuzz::expectOneLine(line);
    for (const hand::TrackedHand& hand : frame->frame.hands)
      if (!hand::faultOfNumbers(hand).empty()) std::abort();
  } catch (const std::runtime_error& error) {
    fuzz::expectOneLine(error.what());
  }
  return 0;
}
