#include "hand/leapjs_recording.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "hand/leap_recording.h"
#include "hand/lz_string.h"
#include "support/error_of.h"
#include "support/leap_message.h"
#include "support/scratch_folder.h"

namespace tactile_clay::hand::leapjs_recording_test {
namespace {

using nlohmann::json;

constexpr std::size_t maximum = 1U << 20U;

TEST(LzString, UnpacksWhatItsOwnTestsPack) {
  EXPECT_EQ(unpackLzString("BYUwNmD2A0AECWsCGBbZtDUzkA==", maximum), "hello, i am a \xE7\x8C\xAB");
  EXPECT_EQ(unpackLzString("IZA=", maximum), "a");
  EXPECT_EQ(unpackLzString("Q===", maximum), "");
}

TEST(LzString, WhatIsNoneIsRefused) {
  EXPECT_NE(errorOf([] { unpackLzString("BYUwNmD2A0AECWsC", maximum); }).find("cut off"), std::string::npos);
  EXPECT_NE(errorOf([] { unpackLzString("BY{}", maximum); }).find("not base64"), std::string::npos);
  EXPECT_NE(errorOf([] { unpackLzString("/w==", maximum); }).find("nobody knows"), std::string::npos);
  EXPECT_NE(errorOf([] { unpackLzString("", maximum); }).find("cut off"), std::string::npos);
  EXPECT_NE(errorOf([] { unpackLzString("BYUwNmD2A0AECWsCGBbZtDUzkA==", 10); }).find("more than 10 bytes"),
            std::string::npos);
}

/// Writes an LZ-string.
class LzWriter {
 public:
  void letter(char16_t letter) {
    code(letter < 256 ? 0 : 1);
    put(letter, letter < 256 ? 8 : 16);
    grow();
  }
  void code(unsigned code) {
    put(code, width_);
    grow();
  }
  std::string base64() {
    code(2);  // the end
    bits_.append((24 - bits_.size() % 24) % 24, '0');
    std::string text;
    for (std::size_t i = 0; i < bits_.size(); i += 6)
      text += "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"[std::stoul(
          bits_.substr(i, 6), nullptr, 2)];
    return text;
  }

 private:
  void put(unsigned value, unsigned count) {
    for (unsigned i = 0; i < count; ++i) bits_ += (value >> i & 1U) != 0 ? '1' : '0';
  }
  void grow() {
    if (--room_ == 0) room_ = 1U << width_++;
  }

  std::string bits_;
  unsigned width_ = 2, room_ = 2;
};

/// An LZ-string that writes each letter as a new one.
std::string packedLzString(const std::u16string& text) {
  LzWriter writer;
  for (const char16_t letter : text) writer.letter(letter);
  return writer.base64();
}

TEST(LzString, LettersOfAnyLengthBecomeUtf8) {
  EXPECT_EQ(unpackLzString(packedLzString(u"x\u00FC\u732B\U0001F600"), maximum), u8"x\u00FC\u732B\U0001F600");
}

TEST(LzString, HalfALetterAloneIsReplaced) {
  const auto unpacked = [](const std::u16string& text) {
    return unpackLzString(packedLzString(text), maximum);
  };
  EXPECT_EQ(unpacked({0xD83D, u'x', 0xDE00}), u8"\uFFFDx\uFFFD");
  EXPECT_EQ(unpacked({0xD83D, 0xD83D, 0xDE00, 0xDE00}), u8"\uFFFD\U0001F600\uFFFD");
  EXPECT_EQ(unpacked({u'x', 0xD83D}), u8"x\uFFFD");
}

// Each code is the last word and its first letter again: n codes make n^2 / 2 letters.
TEST(LzString, HalvesOfLettersCountAsBytes) {
  LzWriter writer;
  writer.letter(0xD800);
  constexpr unsigned codes = 1000, first_free = 4;
  for (unsigned k = 0; k < codes; ++k) writer.code(first_free + k);
  EXPECT_EQ(errorOf([&] { unpackLzString(writer.base64(), maximum); }),
            "unpacks to more than 1048576 bytes, expected at most as many");
}

/// Values of `example`'s names; {"name": [[names]]} for a list of objects.
json namesOf(const json& example) {
  json names = json::array();
  for (const auto& [key, value] : example.items())
    names.push_back(value.is_array() && !value.empty() && value[0].is_object()
                        ? json({{key, {namesOf(value[0])}}})
                        : json(key));
  return names;
}

json valuesOf(const json& names, const json& object) {
  json values = json::array();
  for (const json& name : names) {
    if (name.is_string()) {
      values.push_back(object.at(name.get<std::string>()));
      continue;
    }
    values.push_back(json::array());
    for (const json& item : object.at(name.begin().key()))
      values.back().push_back(valuesOf((*name.begin())[0], item));
  }
  return values;
}

class LeapjsFile : public ScratchFolder {
 protected:
  void SetUp() override {
    ScratchFolder::SetUp();
    for (int i = 0; i < 3; ++i) {
      json message = leapMessage(knownHand(i == 1 ? Side::left : Side::right));
      message["timestamp"] = 1000 + 10 * i;
      messages.push_back(message);
    }
  }

  json packed() const {
    const json names = namesOf(messages[0]);
    json frames = {names};
    for (const json& message : messages) frames.push_back(valuesOf(names, message));
    return {{"metadata", {{"formatVersion", 2}, {"title", "\"frames\": [}"}}}, {"frames", frames}};
  }

  /// Stamps, us, and sides of what is read.
  std::string read(const std::string& file) const {
    LeapRecording recording;
    SourceOptions options;
    options.file = file;
    recording.open(options);
    std::string all;
    TrackedFrame frame;
    while (recording.read(frame, std::chrono::milliseconds(0)) == HandSource::Read::frame) {
      all += std::to_string(frame.stamp / std::chrono::microseconds(1));
      for (const TrackedHand& hand : frame.hands) all += hand.side == Side::left ? "l " : "r ";
    }
    return all + recording.lastDrop();
  }

  std::string openError(const std::string& text) const {
    return errorOf([&] { read(write("bad", text)); });
  }

  json messages = json::array();
};

TEST_F(LeapjsFile, EachWayToSaveItReadsTheSame) {
  const std::string expected = "1000r 1010l 1020r ";
  EXPECT_EQ(read(write("packed.json", packed().dump())), expected);
  EXPECT_EQ(read(write("indented.json", packed().dump(2))), expected);
  EXPECT_EQ(read(write("unpacked.json", json({{"frames", messages}, {"metadata", {}}}).dump())), expected);
  EXPECT_EQ(read(write("array.json", "\n" + messages.dump())), expected);
  const std::string text = packed().dump();
  EXPECT_EQ(read(write("packed.json.lz", packedLzString(std::u16string(text.begin(), text.end())) + "\n")),
            expected);
}

TEST_F(LeapjsFile, AFieldThatAFrameDoesNotHaveIsNull) {
  json recording = packed();
  const json& names = recording["frames"][0];
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].is_object()) recording["frames"][2][i] = nullptr;  // neither hands nor pointables
  EXPECT_EQ(read(write("packed.json", recording.dump())), "1000r 10101020r ");
}

TEST_F(LeapjsFile, WhatIsBrokenSaysSoWhenOpened) {
  const std::string text = packed().dump();
  EXPECT_NE(openError(text.substr(0, text.size() / 2)).find("ends within its JSON"), std::string::npos);
  EXPECT_NE(openError(R"({"metadata":{},"frames":[]})").find("no frames"), std::string::npos);
  std::string many = "[[]", keys = "{\"frames\":[]";
  for (int k = 0; k < 1'000'001; ++k) {
    many += ",[]";
    keys += ",\"\":1";
  }
  EXPECT_NE(openError(many + "]").find("has more than 1000000 frames"), std::string::npos);
  EXPECT_NE(openError(keys + "}").find("has more than 1000000 frames"), std::string::npos);
  EXPECT_NE(openError(R"({"metadata":{},"frames":7})").find("no frames"), std::string::npos);
  EXPECT_NE(openError(packedLzString(u"neither JSON nor anything")).find("no JSON"), std::string::npos);
  EXPECT_NE(openError(std::string(40, 'A')).find("leapjs-playback"), std::string::npos);
  json more = packed();
  more["frames"][1].push_back(1);
  EXPECT_NE(openError(more.dump()).find("frame 1 has 6 values, expected one for each of 5 names"),
            std::string::npos)
      << openError(more.dump());
}

// Names and values are small enough each, but each of the objects would have the long name.
TEST_F(LeapjsFile, ANameThatIsRepeatedTooOftenIsRefused) {
  const std::string name(500'000, 'K');
  const auto line = [&](const std::string& objects) {
    return openError("{\"metadata\":{\"formatVersion\":2},\"frames\":[[{\"hands\":[[\"" + name + "\"]]}],[[" +
                     objects + "]]]}");
  };
  EXPECT_EQ(line("[1],[1]").find("unpacks"), std::string::npos);
  const std::string refused = line("[1],[1],[1]");
  EXPECT_NE(refused.find("frame 1 unpacks to names of more than 1048576 bytes"), std::string::npos)
      << refused;
}

// As in the first protocols: no sides, no bones.
TEST_F(LeapjsFile, HandsWithoutBonesAreRefusedByTheirProtocol) {
  std::string lines = "{\"version\":1}\n{\"id\":1,\"timestamp\":5,\"hands\":[],\"pointables\":[]}\n";
  json message = messages[0];
  for (json& hand : message["hands"]) hand.erase("type");
  for (json& pointable : message["pointables"])
    for (const char* key :
         {"type", "carpPosition", "mcpPosition", "pipPosition", "dipPosition", "btipPosition"})
      pointable.erase(key);
  EXPECT_NE(openError(lines + message.dump() + "\n").find("no bones, as in Leap's protocol 1"),
            std::string::npos);
  EXPECT_NE(openError(message.dump()).find("no bones, as in Leap's protocols 1 to 4"), std::string::npos);
  // Hands without bones are refused also later in a recording.
  EXPECT_NE(read(write("mixed", messages[0].dump() + "\n" + message.dump())).find("no bones"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::hand::leapjs_recording_test
