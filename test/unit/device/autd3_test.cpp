#include "device/autd3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <autd3/native_methods.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <map>
#include <stdexcept>

#include "support/error_of.h"
#include "support/sounds.h"

namespace tactile_clay::device::autd3_test {
namespace {

using namespace std::chrono_literals;
using ultrasound::Modulation;
namespace sdk = ::autd3::native_methods;
using Options = std::map<std::string, std::string>;

class Autd3Test : public ::testing::Test {
 protected:
  void SetUp() override { sdk::standIn().reset(); }

  static Emission emission(Modulation modulation = Modulation::amplitude, double frequency = 200.0) {
    Emission result;
    result.modulation = modulation;
    result.modulation_frequency = frequency;
    result.points.resize(1);
    result.points[0].position = focus();
    result.points[0].intensity = 0.8;
    return result;
  }

  static bool sounds() {
    const sdk::Boards boards = sdk::standIn().now();
    return std::any_of(boards.playing.patterns.begin(), boards.playing.patterns.end(),
                       [](const auto& pattern) {
                         return std::any_of(pattern.begin(), pattern.end(),
                                            [](const sdk::Drive& d) { return d.intensity._0 > 0; });
                       });
  }

  static bool soon(const std::function<bool()>& holds) {
    const auto until = std::chrono::steady_clock::now() + 5s;
    while (std::chrono::steady_clock::now() < until) {
      if (holds()) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }

  /// Pressure, Pa, of the boards at a place, by a sum of the test's own over the data that they received.
  static double heard(std::size_t pattern, const ultrasound::ArrayLayout& layout, const Eigen::Vector3d& at) {
    const auto drives = sdk::standIn().now().playing.patterns.at(pattern);
    ultrasound::Drive drive;
    for (const sdk::Drive& d : drives) {
      drive.phase.push_back(static_cast<float>(2.0 * M_PI * d.phase._0 / 256.0));
      drive.amplitude.push_back(static_cast<float>(d.intensity._0 / 255.0));
    }
    return std::abs(ultrasound::pressureAt(layout, {}, drive, at));
  }

  static Eigen::Vector3d focus() { return {0.02, -0.01, 0.17}; }

  /// Expects that the sound of the boards has the pressure of emission() at its focus.
  /// @return Pa
  double expectFocus() const {
    const auto layout = device.capabilities().layout;
    const double expected = 0.8 * ultrasound::focusPressure(layout, {}, focus());
    EXPECT_NEAR(heard(0, layout, focus()), expected, 0.01 * expected);
    return expected;
  }

  Options options{{"address", "127.0.0.1:8080"}, {"hold", "10"}};
  Autd3 device;
};

TEST_F(Autd3Test, IsSilentUntilSomethingIsSubmitted) {
  EXPECT_EQ(device.fault(), "not open");
  EXPECT_THROW(device.submit(soundOf(emission(), &device)), std::runtime_error);
}

TEST_F(Autd3Test, MakesTheFocusThatTheGateJudged) {
  device.open(options);
  EXPECT_EQ(device.fault(), "");
  EXPECT_FALSE(sounds());
  EXPECT_EQ(device.capabilities().layout.size(), 249u);
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon(sounds));
  const double expected = expectFocus();
  EXPECT_LT(heard(0, device.capabilities().layout, focus() + Eigen::Vector3d(0.04, 0, 0)), 0.3 * expected);
}

TEST_F(Autd3Test, SeveralBoardsAtAnyPoseAreOneArray) {
  options["boards"] = "-0.1 0 0 0 0.3 0  0.1 0 0 0 -0.3 0.1";
  device.open(options);
  EXPECT_EQ(device.capabilities().layout.size(), 498u);
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon(sounds));
  expectFocus();
}

TEST_F(Autd3Test, RefusesALibraryWithItsTransducersElsewhere) {
  sdk::standIn().change([](sdk::Boards& boards) { boards.shift = 1.0f; });
  EXPECT_EQ(errorOf<std::runtime_error>([&] { device.open(options); }),
            "autd3: the library has transducer 0 at another place, expected version 38 of it");
  EXPECT_FALSE(sdk::standIn().now().open);
}

TEST_F(Autd3Test, ModulationIsARaisedCosineOfThePressure) {
  device.open(options);
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon(sounds));
  const sdk::Boards boards = sdk::standIn().now();
  EXPECT_EQ(boards.sample_rate, 4000.0f);
  ASSERT_EQ(boards.modulation.size(), 4000u) << "a second";
  for (std::size_t k = 0; k < boards.modulation.size(); ++k)
    ASSERT_NEAR(std::pow(boards.modulation[k] / 255.0, 2),
                0.5 - 0.5 * std::cos(2.0 * M_PI * 200.0 * static_cast<double>(k) / 4000.0), 0.01);
  const auto steady = autd3Modulation(emission(Modulation::circle, 5.0));
  EXPECT_EQ(*std::min_element(steady.begin(), steady.end()), 255);
}

TEST_F(Autd3Test, SlipVibratesAt30And150Hz) {
  Emission sliding = emission(Modulation::circle, 5.0);
  sliding.slip = 1.0;
  const auto buffer = autd3Modulation(sliding);
  for (const double frequency : {30.0, 150.0, 90.0}) {
    std::complex<double> line = 0.0;
    for (std::size_t k = 0; k < buffer.size(); ++k)
      line += std::pow(buffer[k] / 255.0, 2) *
              std::polar(1.0 / 4000.0, -2.0 * M_PI * frequency * static_cast<double>(k) / 4000.0);
    EXPECT_NEAR(std::abs(line), frequency == 90.0 ? 0.0 : 0.125, 0.003) << frequency;
  }
}

TEST_F(Autd3Test, TakesThePlacesOfACircleInTurn) {
  device.open(options);
  device.submit(soundOf(emission(Modulation::circle, 5.0), &device));
  ASSERT_TRUE(soon(sounds));
  const sdk::Boards boards = sdk::standIn().now();
  ASSERT_EQ(boards.playing.patterns.size(), ultrasound::circle_steps);
  EXPECT_NEAR(boards.playing.frequency, 5.0 * ultrasound::circle_steps, 1e-3);
  const auto layout = device.capabilities().layout;
  const Eigen::Vector3d centre(0.02, -0.01, 0.17);
  for (const std::size_t k : {0u, 5u, 13u}) {
    const double angle = 2.0 * M_PI * static_cast<double>(k) / ultrasound::circle_steps;
    const Eigen::Vector3d at = centre + 0.003 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    EXPECT_NEAR(heard(k, layout, at), 0.8 * ultrasound::focusPressure(layout, {}, at), 30.0) << k;
  }
}

TEST_F(Autd3Test, FieldsHaveTheLevelsOfTheBoards) {
  device.open(options);
  std::vector<ultrasound::FocalPoint> skin;
  for (int i = -4; i <= 4; ++i) {
    skin.emplace_back();
    skin.back().position = {0.005 * i, 0.0, 0.2};
    skin.back().intensity = std::abs(i) < 2 ? 0.2 : 0.0;
  }
  const auto field = device.field(skin, {}, {});
  ASSERT_TRUE(field);
  for (const float phase : field->drives.at(0).phase) {
    const double level = phase / (2.0 * M_PI) * 256.0;
    ASSERT_NEAR(level, std::round(level), 1e-3);
  }
  const float amplitude = field->drives[0].amplitude[0] * 255.0f;
  EXPECT_NEAR(amplitude, std::round(amplitude), 1e-3);
}

TEST_F(Autd3Test, IsSilentWhenToldSoAndInTheEnd) {
  device.open(options);
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon(sounds));
  device.stop();
  EXPECT_TRUE(soon([] { return !sounds(); }));
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon(sounds));
  device.submit({});
  EXPECT_TRUE(soon([] { return !sounds(); })) << "no points are silence";
  {
    Autd3 other;
    other.open(options);
    other.submit(soundOf(emission(), &other));
    ASSERT_TRUE(soon(sounds));
  }
  EXPECT_FALSE(sounds());
  EXPECT_FALSE(sdk::standIn().now().open);
}

TEST_F(Autd3Test, IsSilentWhenNotRenewed) {
  options["hold"] = "0.05";
  device.open(options);
  device.submit(soundOf(emission(), &device));
  EXPECT_TRUE(soon([] { return sdk::standIn().now().modulation.size() == 4000 && !sounds(); }));
}

TEST_F(Autd3Test, ALinkThatIsLostIsToldAndComesBack) {
  options["hold"] = "0.05";
  device.open(options);
  sdk::standIn().change([](sdk::Boards& boards) { boards.good = false; });
  device.submit(soundOf(emission(), &device));
  ASSERT_TRUE(soon([this] { return !device.fault().empty(); }));
  EXPECT_NE(device.fault().find("link closed"), std::string::npos);
  EXPECT_THROW(device.submit(soundOf(emission(), &device)), std::runtime_error);
  sdk::standIn().change([](sdk::Boards& boards) { boards.good = true; });
  EXPECT_TRUE(soon([this] { return device.fault().empty(); }));
  EXPECT_FALSE(sounds());
}

TEST_F(Autd3Test, TellsWhatIsMissing) {
  const auto refusal = [](const Options& given) {
    Autd3 other;
    return errorOf<std::runtime_error>([&] { other.open(given); });
  };
  EXPECT_EQ(refusal({}), "autd3: no address, expected IP:PORT of an AUTD3 server");
  EXPECT_NE(
      refusal({{"address", "a:1"}, {"boards", "0 0 0"}}).find("boards is '0 0 0', expected six numbers"),
      std::string::npos);
  EXPECT_NE(refusal({{"address", "a:1"}, {"hold", "soon"}}).find("hold is 'soon'"), std::string::npos);
  const auto checked = [&](const Options& given) {
    return errorOf<std::runtime_error>([&] { Autd3().requireOptions(given); });
  };
  for (const Options& wrong : {Options{}, {{"address", "a:1"}, {"boards", "0 0 0"}}})
    EXPECT_EQ(checked(wrong), refusal(wrong));
  sdk::standIn().change([](sdk::Boards& boards) { boards.server = false; });
  EXPECT_EQ(refusal({{"address", "a:1"}}), "autd3: 1 boards at 'a:1' do not open: no server");
}

}  // namespace
}  // namespace tactile_clay::device::autd3_test
