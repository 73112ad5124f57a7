#include "device/sonic_surface_corrections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/sonic_surface_boards.h"
#include "device/sonic_surface_protocol.h"
#include "sonic_surface_fixture.h"
#include "support/scratch_folder.h"

namespace tactile_clay::device::sonic_surface_corrections_test {
namespace {

using sonic_surface::Boards;
using sonic_surface::Firmware;

class SonicSurfaceCorrections : public ScratchFolder {
 protected:
  /// A table of 256 lines.
  /// @param other the line of channel 9
  static std::string table(const std::string& other) {
    std::string text = "# a board\nchannel,turns\n";
    for (int n = 0; n < 256; ++n)
      text += n == 9 ? other + "\n" : std::to_string(n) + "," + (n % 3 == 0 ? "flipped" : "0.03125") + "\n";
    return text;
  }

  std::string refusal(const std::string& path) {
    try {
      sonic_surface::readCorrections(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "read";
  }
};

TEST_F(SonicSurfaceCorrections, ComeFromATableOrAFirmware) {
  const auto turns = sonic_surface::readCorrections(write("board.csv", table("9,-0.25\r")));
  ASSERT_EQ(turns.size(), 256u);
  EXPECT_EQ(turns[0], 0.5);
  EXPECT_EQ(turns[1], 0.03125);
  EXPECT_EQ(turns[9], -0.25);
  std::string numbers = "16";
  for (int n = 1; n < 256; ++n) numbers += ", " + std::to_string(n % 33);
  const std::string vhdl =
      "type T is array (0 to 255) of integer range 0 to 32;\n\tconstant PHASE_CORRECTION : T := ";
  const auto of_firmware =
      sonic_surface::readCorrections(write("Distribute.vhd", vhdl + "(" + numbers + ");\n"));
  ASSERT_EQ(of_firmware.size(), 256u);
  EXPECT_EQ(of_firmware[0], 0.5);
  EXPECT_EQ(of_firmware[8], 0.25);
  EXPECT_NE(refusal(write("short.vhd", vhdl + "(1,2,3);")).find("has 3 numbers, expected"),
            std::string::npos);
  EXPECT_NE(refusal(write("none.vhd", "entity")).find("has no PHASE_CORRECTION"), std::string::npos);
  EXPECT_NE(refusal(write("word.vhd", vhdl + "(1,x);")).find("has 'x'"), std::string::npos);
}

TEST_F(SonicSurfaceCorrections, SayWhatIsWrong) {
  EXPECT_NE(refusal("/nowhere.csv").find("/nowhere.csv"), std::string::npos);
  EXPECT_NE(refusal(folder.string()).find(folder.string()), std::string::npos);
  EXPECT_NE(refusal(write("a", "channel;turns\n")).find("line 1 is 'channel;turns', expected the header"),
            std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,much"))).find("line 12 is '9,much', expected turns from -1 to 1"),
            std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,nan"))).find("expected turns"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,1.5"))).find("expected turns"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("256,0"))).find("expected a channel from 0 to 255"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("8,0"))).find("expected each channel once"), std::string::npos);
  EXPECT_NE(refusal(write("a", table(""))).find("has no channel 9"), std::string::npos);
}

/// The judged drive is the one that is heard: the phases on the wire, with the changes that the board makes
/// to them.
TEST_F(SonicSurfaceCorrections, AreInWhatIsSentAndNotInWhatIsHeard) {
  std::mt19937 random(4);
  const auto turn = [&] { return std::uniform_real_distribution<double>(-0.5, 0.5)(random); };
  ultrasound::Drive drive = uniform(256, 0.0f, 1.0f);
  std::vector<double> added(256);
  for (std::size_t n = 0; n < 256; ++n) {
    drive.phase[n] = static_cast<float>(2.0 * M_PI * turn());
    added[n] = turn();
  }
  for (const Firmware firmware : {Firmware::stock, Firmware::tactile}) {
    const Boards boards{firmware, 1, 0};
    const int levels = firmware == Firmware::stock ? 32 : 16;
    const ultrasound::Drive heard = sonic_surface::emitted(drive, firmware, 0, added);
    SonicSurfaceBoards board(1, firmware == Firmware::tactile);
    for (const std::uint8_t byte : sonic_surface::frame(heard, boards, added)) board.feed(byte);
    const ultrasound::Drive sent = board.drive();
    for (std::size_t n = 0; n < 256; ++n) {
      EXPECT_NEAR(
          std::remainder(sent.phase[n] / (2.0 * M_PI) - added[n] - heard.phase[n] / (2.0 * M_PI), 1.0), 0.0,
          1e-5);
      EXPECT_LE(std::abs(std::remainder((heard.phase[n] - drive.phase[n]) / (2.0 * M_PI), 1.0)),
                0.5 / levels + 1e-5);
    }
  }
}

}  // namespace
}  // namespace tactile_clay::device::sonic_surface_corrections_test
