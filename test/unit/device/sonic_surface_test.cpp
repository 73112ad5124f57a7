#include "device/sonic_surface.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "device/sonic_surface_protocol.h"
#include "sonic_surface_fixture.h"
#include "support/error_of.h"
#include "support/sounds.h"

namespace tactile_clay::device::sonic_surface_test {
namespace {

TEST_F(SonicSurfaceOnATerminal, SendsWhatItSaysThatItSends) {
  const auto silence = sonic_surface::silence(one_board);
  {
    SonicSurface device;
    device.open(options);
    EXPECT_EQ(read(silence.size()), silence) << "first of all it silences both buffers";
    ASSERT_EQ(device.capabilities().layout.size(), 256u);
    EXPECT_NEAR(device.capabilities().max_rate, 89.0, 0.1);
    device.submit(soundOf(focus(), &device));
    const auto bytes = read(259);
    EXPECT_EQ(bytes, sonic_surface::frame(*device.drive(focus().points), one_board));
    EXPECT_EQ(read(3), (std::vector<std::uint8_t>{0xFD, 0xFD, 0xFD})) << "modulation";
    EXPECT_EQ(device.fault(), "");
  }
  // The driver's silence, or the guard's own if the guard dropped the rest; the last bytes show which.
  std::vector<std::uint8_t> rest = read(4096);
  const auto size = static_cast<std::ptrdiff_t>(silence.size());
  ASSERT_GE(rest.size(), silence.size());
  EXPECT_EQ(std::vector<std::uint8_t>(rest.end() - size, rest.end()), silence);
}

TEST_F(SonicSurfaceOnATerminal, DoesNotPlayWhatTheWireIsTooSlowFor) {
  SonicSurface device;
  device.open(options);
  EXPECT_EQ(device.capabilities().modulations,
            (std::vector<ultrasound::Modulation>{ultrasound::Modulation::amplitude,
                                                 ultrasound::Modulation::field}));
  Emission path = focus();
  path.modulation = ultrasound::Modulation::spatiotemporal;
  EXPECT_THROW(device.submit(soundOf(path, &device)), std::runtime_error);
}

// New patterns are sent between two half periods of the sound. At 0.5 Hz old points would sound for a second.
TEST_F(SonicSurfaceOnATerminal, RefusesAModulationThatWouldHoldBackNewPoints) {
  SonicSurface device;
  device.open(options);
  Emission slow = focus();
  slow.modulation_frequency = 19.0;
  EXPECT_THROW(device.submit(soundOf(slow, &device)), std::runtime_error);
  slow.modulation_frequency = 20.0;
  EXPECT_NO_THROW(device.submit(soundOf(slow, &device)));
}

// A port of boards always has its guard. The multiplexer of pseudo-terminals stands for one: it is a
// terminal, and no end of a pseudo-terminal.
TEST_F(SonicSurfaceOnATerminal, NoPortOfBoardsIsWithoutItsGuard) {
  options["guard"] = "false";
  SonicSurface on_pseudo_terminal;
  EXPECT_NO_THROW(on_pseudo_terminal.open(options));
  options["port"] = "/dev/ptmx";
  SonicSurface on_port;
  EXPECT_EQ(errorOf([&] { on_port.open(options); }),
            "sonic_surface: '/dev/ptmx': guard is false, expected true on a port of boards");
}

TEST_F(SonicSurfaceOnATerminal, GoesSilentWhenNotRenewed) {
  options["hold"] = "0.05";
  options["guard"] = "false";
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  Emission steady = focus();
  steady.modulation_frequency = 0.0;
  device.submit(soundOf(steady, &device));
  EXPECT_NE(countOff(read(259)), 256u);
  EXPECT_EQ(read(sonic_surface::silence(one_board).size()), sonic_surface::silence(one_board));
}

TEST_F(SonicSurfaceOnATerminal, ChangeFromSteadyToModulatedPutsSilenceBehindThePattern) {
  options["guard"] = "false";
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  Emission emission = focus();
  emission.modulation_frequency = 0.0;
  device.submit(soundOf(emission, &device));
  read(259);
  emission.modulation_frequency = 200.0;
  device.submit(soundOf(emission, &device));
  EXPECT_EQ(read(sonic_surface::silence(one_board).size()), sonic_surface::silence(one_board));
  EXPECT_EQ(countOff(read(259)), 0u);
}

TEST_F(SonicSurfaceOnATerminal, TellsWhenThePortIsGone) {
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  ::close(master);
  for (int wait = 0; wait < 200 && device.fault().empty(); ++wait) ::usleep(10000);
  EXPECT_NE(device.fault().find("is gone"), std::string::npos) << device.fault();
  EXPECT_NE(device.fault().find(options["port"]), std::string::npos) << device.fault();
  EXPECT_THROW(device.submit(soundOf(focus(), &device)), std::runtime_error);
  device.stop();
}

TEST_F(SonicSurfaceOnATerminal, HasOneOwner) {
  SonicSurface device, second;
  device.open(options);
  EXPECT_THROW(second.open(options), std::runtime_error);
}

}  // namespace
}  // namespace tactile_clay::device::sonic_surface_test
