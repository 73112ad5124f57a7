// Options of devices are read as text, and checked before a device is opened.
#include "device/options.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "device/debug_device.h"
#include "device/sonic_surface.h"
#include "support/error_of.h"

namespace tactile_clay::device::options_test {
namespace {

using Options = std::map<std::string, std::string>;

TEST(Options, AreWordsWithAKeyAndMayHaveValuesOfSeveralWords) {
  const Options options = optionsOf("here", "boards=2 second_board=0 0.17 0  0 0 1.57 firmware=stock");
  EXPECT_EQ(options,
            (Options{{"boards", "2"}, {"second_board", "0 0.17 0 0 0 1.57"}, {"firmware", "stock"}}));
  EXPECT_EQ(optionsOf("here", ""), Options());
  EXPECT_EQ(errorOf<std::runtime_error>([] { optionsOf("here", "stock boards=2"); }),
            "here: 'stock boards=2', expected key=value ...");
}

TEST(Options, LeaveTheTemperatureToTheNode) {
  requireNoTemperature("here", {{"boards", "2"}});
  EXPECT_NE(errorOf<std::runtime_error>([] {
              requireNoTemperature("here", {{"temperature", "20"}});
            }).find("here: has the option temperature, expected it as parameter"),
            std::string::npos);
}

TEST(Options, AreCheckedWithoutOpeningTheDevice) {
  const auto refusal = [](const ArrayDevice& device, const Options& options) {
    return errorOf<std::runtime_error>([&] { device.requireOptions(options); });
  };
  const SonicSurface boards;
  boards.requireOptions({{"port", "/a/port/that/is/not/there"}});
  EXPECT_EQ(boards.fault(), "not open");
  EXPECT_EQ(refusal(boards, {}), "sonic_surface: no port, expected the device file of a serial port");
  for (const auto& [key, value] : Options{{"firmware", "own"},
                                          {"boards", "3"},
                                          {"hold", "soon"},
                                          {"second_board", "0 0 0"},
                                          {"corrections", "/a/file/that/is/not/there"}})
    EXPECT_NE(refusal(boards, {{"port", "/a/port"}, {key, value}}).find(value), std::string::npos) << key;
  const DebugDevice debug;
  debug.requireOptions({});
  EXPECT_NE(refusal(debug, {{"log_rate", "fast"}}).find("log_rate is 'fast'"), std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::device::options_test
