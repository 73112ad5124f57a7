#include "device/ultraleap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <map>
#include <stdexcept>

#include "support/error_of.h"
#include "support/sounds.h"

namespace tactile_clay::device::ultraleap_test {
namespace {

using namespace std::chrono_literals;
namespace sdk = ::Ultraleap::Haptics;

class UltraleapTest : public ::testing::Test {
 protected:
  void SetUp() override { sdk::standIn() = {}; }

  static Emission emission(std::size_t points, double frequency = 200.0) {
    Emission result;
    result.modulation_frequency = frequency;
    result.points.resize(points);
    for (std::size_t i = 0; i < points; ++i) {
      result.points[i].position = {0.01 * static_cast<double>(i), -0.02, 0.17};
      result.points[i].intensity = 0.8;
    }
    return result;
  }

  static sdk::OutputInterval stream(std::chrono::milliseconds after = 0ms) {
    return sdk::standIn().stream(sdk::LocalTimeClock::now() + after, 25us, 400);  // 10 ms
  }

  static std::string refusal(const std::map<std::string, std::string>& options = {}) {
    Ultraleap device;
    try {
      device.open(options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "opened";
  }

  Ultraleap device;
};

TEST_F(UltraleapTest, IsSilentUntilSomethingIsSubmitted) {
  EXPECT_EQ(device.fault(), "not open");
  EXPECT_THROW(device.submit(soundOf(emission(1))), std::runtime_error);
  device.open({});
  EXPECT_EQ(device.fault(), "");
  EXPECT_TRUE(sdk::standIn().started);
  EXPECT_TRUE(stream().empty());
}

TEST_F(UltraleapTest, AsksTheArrayHowManyPointsItCanDo) {
  device.open({});
  EXPECT_EQ(device.capabilities().max_points, 4u);
  EXPECT_THROW(device.submit(soundOf(emission(5))), std::runtime_error);
  sdk::standIn() = {};
  Ultraleap one;
  one.open({{"max_points", "1"}});
  EXPECT_EQ(one.capabilities().max_points, 1u);
}

TEST_F(UltraleapTest, SaysHowOftenItWantsToBeAsked) {
  device.open({});
  EXPECT_EQ(sdk::standIn().callback_rate, 500.0f);
  sdk::standIn() = {};
  Ultraleap often;
  often.open({{"callback_rate", "800"}});
  EXPECT_EQ(sdk::standIn().callback_rate, 800.0f);
}

TEST_F(UltraleapTest, StreamsModulatedPoints) {
  device.open({});
  device.submit(soundOf(emission(2)));
  const auto samples = stream();
  ASSERT_EQ(samples.size(), 400u);
  double low = 1.0, high = 0.0, mean = 0.0;
  int peaks = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& points = samples[i].points_;
    ASSERT_EQ(points.size(), 4u);
    EXPECT_NEAR(points[1].position_.x, 0.01, 1e-6);
    EXPECT_NEAR(points[1].position_.y, -0.02, 1e-6);
    EXPECT_NEAR(points[1].position_.z, 0.17, 1e-6);
    EXPECT_EQ(points[0].intensity_, points[1].intensity_);
    EXPECT_EQ(points[2].intensity_, 0.0f) << "points that are not used are silent";
    const double intensity = points[0].intensity_;
    low = std::min(low, intensity);
    high = std::max(high, intensity);
    mean += intensity / static_cast<double>(samples.size());
    if (i > 0 && i + 1 < samples.size() && intensity >= samples[i - 1].points_[0].intensity_ &&
        intensity > samples[i + 1].points_[0].intensity_)
      ++peaks;
  }
  EXPECT_NEAR(low, 0.0, 1e-3);
  EXPECT_NEAR(high, 0.8, 1e-3);
  EXPECT_NEAR(mean, 0.4, 1e-2);
  EXPECT_EQ(peaks, 2) << "200 Hz over 10 ms";
}

TEST_F(UltraleapTest, UnmodulatedPointsAreSteady) {
  device.open({});
  device.submit(soundOf(emission(1, 0.0)));
  for (const auto& sample : stream()) EXPECT_FLOAT_EQ(sample.points_[0].intensity_, 0.8f);
}

TEST_F(UltraleapTest, VibratesWhereClaySlides) {
  device.open({});
  Emission sliding = emission(1, 0.0);
  sliding.slip = 1.0;
  device.submit(soundOf(sliding));
  double low = 1.0, high = 0.0;
  std::complex<double> at_150 = 0.0;
  const auto samples = sdk::standIn().stream(sdk::LocalTimeClock::now(), 50us, 2000);  // 0.1 s: three periods
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double intensity = samples[i].points_[0].intensity_ / 0.8;
    low = std::min(low, intensity);
    high = std::max(high, intensity);
    at_150 += intensity * std::polar(1.0 / 2000.0, -2.0 * M_PI * 150.0 * 50e-6 * static_cast<double>(i));
  }
  EXPECT_NEAR(low, 0.0, 1e-3);
  EXPECT_NEAR(high, 1.0, 1e-3);
  EXPECT_NEAR(std::abs(at_150), 0.125, 1e-3) << "as ultrasound::slipWave";
}

TEST_F(UltraleapTest, MovesPointsToAndFro) {
  device.open({});
  Emission lateral = emission(2, 100.0);
  lateral.modulation = ultrasound::Modulation::lateral;
  device.submit(soundOf(lateral));
  float low = 1.0f, high = -1.0f;
  for (const auto& sample : stream()) {  // one period
    const auto& points = sample.points_;
    EXPECT_FLOAT_EQ(points[0].intensity_, 0.8f);
    EXPECT_NEAR(points[1].position_.x - points[0].position_.x, 0.01, 1e-6) << "all points move as one";
    low = std::min(low, points[0].position_.x);
    high = std::max(high, points[0].position_.x);
  }
  EXPECT_NEAR(low, -0.003, 1e-6);
  EXPECT_NEAR(high, 0.003, 1e-6);
}

TEST_F(UltraleapTest, RunsAlongAPathWithOnePoint) {
  device.open({});
  Emission path = emission(20, 100.0);  // more places than the array has points
  path.modulation = ultrasound::Modulation::spatiotemporal;
  device.submit(soundOf(path));
  std::map<int, int> visits;  // samples at each place, by cm
  for (const auto& sample : stream()) {
    const auto& points = sample.points_;
    EXPECT_FLOAT_EQ(points[0].intensity_, 0.8f);
    for (std::size_t i = 1; i < points.size(); ++i) EXPECT_EQ(points[i].intensity_, 0.0f);
    ++visits[static_cast<int>(std::lround(100.0f * points[0].position_.x))];
  }
  ASSERT_EQ(visits.size(), 20u) << "10 ms are a period of 20 places";
  for (const auto& [place, samples] : visits) EXPECT_NEAR(samples, 20, 1) << place;
}

TEST_F(UltraleapTest, IsSilentWhenToldSoAndGoesOn) {
  device.open({});
  device.submit(soundOf(emission(1, 0.0)));
  ASSERT_FALSE(stream().empty());
  device.stop();
  EXPECT_TRUE(stream().empty()) << "paused";
  device.submit(soundOf(emission(1, 0.0)));
  EXPECT_FLOAT_EQ(stream().front().points_[0].intensity_, 0.8f);
  device.submit({});
  EXPECT_TRUE(stream().empty()) << "no points are silence";
}

TEST_F(UltraleapTest, IsSilentWhenNotRenewed) {
  device.open({{"hold", "0.1"}});
  device.submit(soundOf(emission(1, 0.0)));
  EXPECT_FLOAT_EQ(stream(50ms).front().points_[0].intensity_, 0.8f);
  for (const auto& sample : stream(101ms))
    for (const auto& point : sample.points_) EXPECT_EQ(point.intensity_, 0.0f);
}

TEST_F(UltraleapTest, StopsTheArrayInTheEnd) {
  {
    Ultraleap other;
    other.open({});
    other.submit(soundOf(emission(1)));
    EXPECT_TRUE(sdk::standIn().started);
  }
  EXPECT_FALSE(sdk::standIn().started);
}

TEST_F(UltraleapTest, TellsWhatIsMissing) {
  sdk::standIn().service = false;
  EXPECT_EQ(refusal(),
            "ultraleap: the haptics service cannot be reached: no service; expected a running service");
  sdk::standIn().service = true;
  sdk::standIn().connected = false;
  EXPECT_EQ(refusal(), "ultraleap: no array: no device; expected one that streams, connected");
  sdk::standIn().connected = true;
  sdk::standIn().max_points = 0;
  EXPECT_NE(refusal().find("no control points: too many"), std::string::npos);
  sdk::standIn().max_points = 4;
  EXPECT_NE(refusal({{"callback_rate", "2000"}}).find("callback_rate is 2000"), std::string::npos)
      << "more than the array can do";
  EXPECT_NE(refusal({{"callback_rate", "0"}}).find("callback_rate is '0'"), std::string::npos);
  EXPECT_NE(refusal({{"hold", "soon"}}).find("hold is 'soon'"), std::string::npos);
  const auto checked = [] { Ultraleap().requireOptions({{"hold", "soon"}}); };
  EXPECT_EQ(errorOf<std::runtime_error>(checked), refusal({{"hold", "soon"}}));
}

}  // namespace
}  // namespace tactile_clay::device::ultraleap_test
