#include "clay/sculpture.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <vector>

#include "clay/clay.h"
#include "clay/sculpture_file.h"
#include "clay_frames.h"
#include "support/setups.h"

namespace tactile_clay::clay::sculpture_test {
namespace {

using namespace clay_frames;

class SculptureTest : public testing::Test {
 protected:
  ~SculptureTest() override { std::remove(file_.c_str()); }

  /// Two blocks of two materials, the upper about to fall onto the lower, both on a sloping floor.
  Clay start(int threads = 1) {
    Material soft, stiff;
    soft.name = "soft";
    stiff.name = "stiff";
    stiff.stiffness = 2e5;
    auto particles = block(6, 6, 4, spacing);
    for (InitialParticle p : block(4, 4, 4, spacing, {0.0, 0.0, 0.023}, Eigen::Matrix3d::Identity(), 1)) {
      p.body = 1;
      particles.push_back(p);
    }
    ClayConfig config;
    config.spacing = spacing;
    config.threads = threads;
    return Clay(config, {soft, stiff}, particles);
  }
  /// Frames [first, last) of a finger that presses in from above.
  void press(Clay& clay, int first, int last) {
    for (int k = first; k < last; ++k) {
      const Eigen::Vector3d velocity(0.0, 0.0, -0.1), from(0.0, 0.0, 0.055);
      const double t = (k + 1) * clay.config().frame;
      clay.advance(samplePlane(from + t * velocity, -Eigen::Vector3d::UnitZ(), 0.006, 0.003, velocity),
                   {ground(0.2)}, clay.config().frame);
    }
  }
  std::string bytes() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }
  std::string fault() const {
    try {
      loadSculpture(file_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  const std::string file_ = testing::TempDir() + "sculpture_test.clay";
};

/// kB.
long peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Saved while the blocks are in motion, bonded, pressed and stuck to the floor; continued by a new clay, as
/// in another process, with another number of threads.
TEST_F(SculptureTest, GoesOnToTheBit) {
  Clay whole = start();
  press(whole, 0, 20);
  ASSERT_GT(whole.statistics().bonds, 1000u);
  ASSERT_GT(whole.skinForces().size(), 3u);
  save(whole.sculpture(), file_);
  press(whole, 20, 40);

  Clay continued = start(2);
  press(continued, 0, 3);  // what it was before does not show
  continued.restore(loadSculpture(file_));
  press(continued, 20, 40);
  EXPECT_EQ(continued.time(), whole.time());
  EXPECT_EQ(continued.statistics().bonds, whole.statistics().bonds);
  EXPECT_TRUE(sameBits(continued.particles().position, whole.particles().position));
  EXPECT_TRUE(sameBits(continued.particles().velocity, whole.particles().velocity));
  ASSERT_EQ(continued.skinForces().size(), whole.skinForces().size());
  for (std::size_t k = 0; k < whole.skinForces().size(); ++k)
    EXPECT_EQ(continued.skinForces()[k].force, whole.skinForces()[k].force);
}

TEST_F(SculptureTest, IsSavedAsItIs) {
  Clay clay = start();
  press(clay, 0, 10);
  save(clay.sculpture(), file_);
  const std::string once = bytes();
  save(loadSculpture(file_), file_);
  EXPECT_EQ(bytes(), once);
  Clay other = start();
  other.restore(loadSculpture(file_));
  save(other.sculpture(), file_);
  EXPECT_EQ(bytes(), once);
}

/// A file that is cut off anywhere, or has any high bit inverted, is read or refused; nothing breaks.
TEST_F(SculptureTest, DamageIsSaidOrHarmless) {
  Clay clay = start();
  press(clay, 0, 10);
  save(clay.sculpture(), file_);
  const std::string whole = bytes();
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 97) {
    write(whole.substr(0, length));
    EXPECT_NE(fault().find("sculpture '" + file_ + "'"), std::string::npos) << length;
  }
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 397) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x80);
    write(damaged);
    if (!fault().empty()) continue;
    Clay other = start();
    try {
      other.restore(loadSculpture(file_));
    } catch (const std::invalid_argument&) {
      continue;
    }
    press(other, 10, 12);
    for (std::size_t i = 0; i < other.particles().size(); ++i)
      ASSERT_TRUE(other.particles().position.at(i).allFinite()) << "byte " << at;
  }
}

/// A seeded fuzzer over a good file: bytes of numbers, counts and places get the worst values of their kinds.
/// A file that is read can be continued: a frame ends, and leaves finite numbers.
TEST_F(SculptureTest, FuzzedFilesAreRefusedOrHarmless) {
  Clay clay = start();
  press(clay, 0, 10);
  save(clay.sculpture(), file_);
  const std::string whole = bytes();
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::vector<std::string> worst = {std::string(8, '\0'),
                                          std::string(8, '\xff'),
                                          std::string("\0\0\xc0\x7f", 4),
                                          std::string("\0\0\x80\x7f", 4),
                                          std::string("\0\0\x80\xff", 4),
                                          std::string("\xff\xff\x7f\x7f", 4),
                                          std::string("\xff\xff\xff\x7f", 4),
                                          std::string("\0\0\0\0\0\0\xf0\x7f", 8),
                                          std::string("\0\0\0\0\1\0\0\0", 8),
                                          std::string("\x28\x6b\x6e\x4e", 4)};
  int refused = 0, taken = 0;
  for (int round = 0; round < 400; ++round) {
    std::string damaged = whole;
    for (std::size_t change = 0, changes = 1 + below(4); change < changes; ++change) {
      const std::string& bad = worst[below(worst.size())];
      // Half of them in the head, where times and counts are.
      const std::size_t at = below(round % 2 == 0 ? 200 : damaged.size() - bad.size());
      damaged.replace(at, bad.size(), bad);
    }
    if (round % 7 == 0) damaged.resize(below(damaged.size()));
    if (round % 11 == 0) damaged.append(below(100), 'x');
    write(damaged);
    const std::string line = fault();
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    if (!line.empty()) {
      ++refused;
      continue;
    }
    Clay other = start();
    try {
      other.restore(loadSculpture(file_));
    } catch (const std::invalid_argument&) {
      ++refused;
      continue;
    }
    ++taken;
    press(other, 10, 11);
    for (std::size_t i = 0; i < other.particles().size(); ++i)
      ASSERT_TRUE(other.particles().position.at(i).allFinite()) << "round " << round;
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(taken, 20);
}

TEST_F(SculptureTest, ReplacesNothingUnasked) {
  Clay clay = start();
  write("precious");
  EXPECT_THROW(save(clay.sculpture(), file_, files::Existing::keep), std::runtime_error);
  EXPECT_EQ(bytes(), "precious");
  save(clay.sculpture(), file_, files::Existing::replace);
  EXPECT_EQ(fault(), "");
  EXPECT_THROW(save(clay.sculpture(), "/dev/null", files::Existing::replace), std::runtime_error);
}

TEST_F(SculptureTest, OfAnotherSceneIsRefused) {
  Clay clay = start();
  const Sculpture mine = clay.sculpture();
  ClayConfig config = clay.config();
  Clay smaller(config, {Material(), Material()}, block(3, 3, 3, spacing));
  EXPECT_THROW(smaller.restore(mine), std::invalid_argument);
  auto particles = block(6, 6, 4, spacing);
  for (const InitialParticle& p : block(4, 4, 4, spacing, {0.0, 0.0, 0.03})) particles.push_back(p);
  Clay plain(config, {Material(), Material()}, particles);
  EXPECT_THROW(plain.restore(mine), std::invalid_argument);
  config.spacing = 0.006;
  Sculpture coarse = mine;
  coarse.spacing = 0.006;
  EXPECT_THROW(clay.restore(coarse), std::invalid_argument);
}

TEST_F(SculptureTest, SaysWhatIsWrong) {
  EXPECT_NE(fault().find("cannot be opened"), std::string::npos);
  write("tactile_clay sculpture 0\n");
  EXPECT_NE(fault().find("is not a sculpture"), std::string::npos);
  write("no sculpture, and much of it\n");
  for (const auto& [size, words] :
       {std::pair(1L << 30, "is not a sculpture"), {3L << 30, "expected at most"}}) {
    ASSERT_EQ(truncate(file_.c_str(), size), 0);
    const long before = peakMemory();
    EXPECT_NE(fault().find(words), std::string::npos) << fault();
    EXPECT_LT(peakMemory() - before, 100000) << "kB";
  }
  Clay clay = start();
  try {
    save(clay.sculpture(), "/nowhere/at/all.clay");
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/at/all.clay"), std::string::npos);
  }
}

}  // namespace
}  // namespace tactile_clay::clay::sculpture_test
