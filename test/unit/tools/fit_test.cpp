#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scene/scene.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"
#include "tools/material_fit.h"
#include "tools/nelder_mead.h"
#include "tools/press_curve.h"

namespace tactile_clay::tools::fit_test {
namespace {

TEST(NelderMead, FindsTheEndOfAValley) {
  const auto rosenbrock = [](const Point& p) {
    return std::pow(1.0 - p[0], 2.0) + 100.0 * std::pow(p[1] - p[0] * p[0], 2.0);
  };
  const Minimum found = nelderMead(rosenbrock, {-1.2, 1.0}, 0.5, 1e-6, 1000);
  EXPECT_NEAR(found.at[0], 1.0, 1e-4);
  EXPECT_NEAR(found.at[1], 1.0, 1e-4);
  EXPECT_LT(found.evaluations, 300);
}
TEST(NelderMead, StopsAfterSoManyEvaluations) {
  const auto slope = [](const Point& p) { return p[0]; };
  EXPECT_LE(nelderMead(slope, {0.0}, 1.0, 1e-9, 20).evaluations, 21);
}

class CurveFile : public ScratchFolder {
 protected:
  /// What reading such a file says behind its name.
  std::string errorOfCurve(const std::string& text) const {
    const std::string file = write("curve.csv", text), error = errorOf([&] { readPressCurve(file); });
    return error.rfind(file, 0) == 0 ? error.substr(file.size()) : error;
  }
};

TEST_F(CurveFile, IsReadWithHeadingAndComments) {
  const PressCurve curve = readPressCurve(write("curve.csv",
                                                "time,depth,force\n# loading\n0,0,0\r\n0.1,0.001,2\n"
                                                "0.2, 0.002, 4.5 # here\n\n0.3,0.002,4\n1,0,-1e-1\n"));
  ASSERT_EQ(curve.size(), 5U);
  EXPECT_EQ(curve[2].depth, 0.002);
  EXPECT_EQ(curve[4].force, -0.1);
}
TEST_F(CurveFile, OfBadLinesIsToldWithTheLine) {
  EXPECT_EQ(errorOfCurve("time,depth,force\n0,0\n"),
            ":2: has 2 values, expected three: time in s, depth in m, force in N");
  EXPECT_EQ(errorOfCurve("0,0,0\n0.1,deep,1\n"), ":2: depth 'deep': expected a number from -1e+09 to 1e+09");
  EXPECT_EQ(errorOfCurve("0,0,0\n0.1,nan,1\n"), ":2: depth 'nan': expected a number from -1e+09 to 1e+09");
  EXPECT_EQ(errorOfCurve("0,0,0\n0.1,0.001,1\n0.1,0.002,2\n"),
            ":3: time 0.1 s is not after the one before, expected ascending times");
  EXPECT_EQ(errorOfCurve("0,0,0\n600,0.001,1\n"),
            ":2: time 600 s is more than 120 s after the first, expected a shorter curve");
  EXPECT_EQ(errorOfCurve("0,0,0\n1,0.001,1\n"), ": has 2 moments, expected 5 or more");
}

/// A disc goes into a small block slowly, rests, goes on fast, rests, and comes out.
struct Press {
  Press() {
    setup.sample.size = {0.032, 0.032, 0.02};
    setup.budget = {2, 8, clay::Method::minimise};
    double t = 0.0, depth = 0.0;
    const auto to = [&](double deeper, double duration) {
      const int rows = static_cast<int>(std::lround(duration / 0.02));
      for (int k = 1; k <= rows; ++k)
        curve.push_back({t + 0.02 * k, depth + (deeper - depth) * k / rows, 0.0});
      t += 0.02 * rows;
      depth = deeper;
    };
    curve.push_back({0.0, 0.0, 0.0});
    to(0.002, 0.4);
    to(0.002, 0.2);
    to(0.006, 0.06);
    to(0.006, 0.2);
    to(0.003, 0.1);
    windows = windowsOf(curve);
  }
  std::vector<double> forces(const clay::Material& m) const { return modelForces(setup, m, curve, windows); }

  PressSetup setup;
  PressCurve curve;
  std::vector<Window> windows;
};

clay::Material known() {
  clay::Material m;
  m.stiffness = 4e5;
  m.yield_strain = 0.02;
  m.viscosity = 2000.0;
  m.bulk_modulus = 4e6;
  return m;
}

/// Forces of the model with noise of 1 % of the greatest of them, of a fixed seed.
std::vector<double> noisy(std::vector<double> forces) {
  std::mt19937 random(36);
  std::normal_distribution<double> noise(0.0, 0.01 * *std::max_element(forces.begin(), forces.end()));
  for (double& f : forces) f += noise(random);
  return forces;
}

/// What made a curve comes out again: yield stress within 10 %, stiffness within 20 %, viscosity within 30 %.
TEST(FitMaterial, GivesBackWhatMadeTheCurve) {
  const Press press;
  clay::Material start;
  start.viscosity = 400.0;
  const MaterialFit fit =
      fitMaterial([&](const clay::Material& m) { return press.forces(m); }, noisy(press.forces(known())),
                  start, 1e4, {"stiffness", "yield_stress", "viscosity"}, 80);
  const clay::Material expected = known();
  const double yield_stress = 2.0 * expected.stiffness * expected.yield_strain;
  EXPECT_NEAR(fit.material.stiffness, expected.stiffness, 0.2 * expected.stiffness);
  EXPECT_NEAR(2.0 * fit.material.stiffness * fit.material.yield_strain, yield_stress, 0.1 * yield_stress);
  EXPECT_NEAR(fit.material.viscosity, expected.viscosity, 0.3 * expected.viscosity);
  EXPECT_GE(fit.material.bulk_modulus, 10.0 * fit.material.stiffness);
  EXPECT_LT(fit.error, 0.05);
  for (const FitParameter& p : fit.parameters) EXPECT_TRUE(p.determined()) << p.name << " " << p.error;
}

/// Forces of a press too light to yield, N.
std::vector<double> elastic(const clay::Material& m) {
  std::vector<double> forces;
  for (int k = 0; k < 50; ++k) forces.push_back(1e-6 * m.stiffness * k);
  return forces;
}

/// A press too light to yield tells nothing of the yield stress, and says so.
TEST(FitMaterial, TellsWhatTheCurveCannot) {
  clay::Material m;
  m.stiffness = 3e5;
  const MaterialFit fit =
      fitMaterial(elastic, noisy(elastic(m)), clay::Material(), 1e4, {"stiffness", "yield_stress"}, 120);
  EXPECT_NEAR(fit.material.stiffness, m.stiffness, 0.02 * m.stiffness);
  EXPECT_TRUE(fit.parameters[0].determined());
  EXPECT_FALSE(fit.parameters[1].determined());
  EXPECT_NE(materialFile(fit, {}).find("# not determined by the curve: yield_stress"), std::string::npos);
}

/// One reading out of ten is wrong by as much as the greatest force: the fit does not follow them.
TEST(FitMaterial, DoesNotFollowStrays) {
  clay::Material m;
  m.stiffness = 3e5;
  std::vector<double> measured = elastic(m);
  for (std::size_t k = 5; k < measured.size(); k += 10) measured[k] += measured.back();
  const MaterialFit fit = fitMaterial(elastic, measured, clay::Material(), 1e4, {"stiffness"}, 120);
  EXPECT_NEAR(fit.material.stiffness, m.stiffness, 0.05 * m.stiffness);
}

class MaterialFile : public ScratchFolder {};
TEST_F(MaterialFile, IsReadByScenes) {
  MaterialFit fit;
  fit.material = known();
  fit.material.relaxation_time = 2.5;
  fit.material.flow_index = 0.4;
  fit.material.adhesion = 1234.5;
  const clay::Material read =
      scene::loadMaterial(write("mine.yaml", materialFile(fit, {"Fitted to a curve"})), TACTILE_CLAY_SHARE);
  EXPECT_EQ(read.name, "mine");
  EXPECT_EQ(read.stiffness, 4e5);
  EXPECT_EQ(read.bulk_modulus, 4e6);
  EXPECT_EQ(read.yield_strain, 0.02);
  EXPECT_EQ(read.viscosity, 2000.0);
  EXPECT_EQ(read.relaxation_time, 2.5);
  EXPECT_EQ(read.flow_index, 0.4);
  EXPECT_NEAR(read.adhesion, 1234.5, 1.0);
  EXPECT_EQ(read.skin_friction, fit.material.skin_friction);
}

TEST(FitMaterial, KnowsItsParameters) {
  const auto nothing = [](const clay::Material&) { return std::vector<double>{1.0}; };
  EXPECT_EQ(
      errorOf([&] { fitMaterial(nothing, {1.0}, clay::Material(), 1e4, {"hue"}, 10); }),
      "parameter 'hue', expected some of stiffness, yield_stress, viscosity, relaxation_time, friction");
}

TEST(PressSetup, IsCheckedAgainstTheCurve) {
  Press press;
  press.curve[3].force = 1.0;
  EXPECT_NO_THROW(check(press.setup, press.curve));
  const auto errorWith = [&](const auto& change) {
    Press changed = press;
    change(changed);
    return errorOf([&] { check(changed.setup, changed.curve); });
  };
  EXPECT_EQ(errorWith([](Press& p) { p.curve[3].force = 0.0; }),
            "the clay never presses the tool, expected a force above 0 N: upward, on the tool");
  EXPECT_EQ(errorWith([](Press& p) {
              for (PressSample& s : p.curve) s.depth = 0.0;
            }),
            "the tool never touches the clay, expected a depth above 0 m");
  EXPECT_EQ(errorWith([](Press& p) { p.curve[5].depth = 0.018; }),
            "the tool goes 0.018 m deep, expected at most 0.8 times the height of the sample, 0.02 m");
  EXPECT_EQ(errorWith([](Press& p) { p.curve[0].depth = 0.003; }),
            "the curve begins 0.003 m deep, expected it to begin where the tool touches, at 0 m");
  EXPECT_EQ(errorWith([](Press& p) { p.setup.spacing = 1e-4; }),
            "spacing 0.0001 m makes 20480000 particles, expected at most 200000");
}

/// A window's force is the mean of the straight lines between the moments in it.
TEST(PressSetup, MeansOfACurveAreExact) {
  const PressCurve curve{{0.0, 0.0, 0.0}, {0.01, 0.0, 1.0}, {0.04, 0.0, 1.0}, {0.05, 0.0, 3.0}};
  const std::vector<double> means = measuredForces(curve, {{0.0, 0.02}, {0.04, 0.05}});
  EXPECT_NEAR(means[0], 0.75, 1e-12);
  EXPECT_NEAR(means[1], 2.0, 1e-12);
}

/// A sphere and a plate press as they should: Hertz's 16/3 G sqrt(R) d^1.5 within 30 %, and 3 G A d / h of an
/// incompressible cylinder on a slippery table within 15 %, both at a coarse spacing.
TEST(PressSetup, PressesWithSphereAndPlate) {
  clay::Material elastic;
  elastic.stiffness = 1e5;
  elastic.bulk_modulus = 1e6;
  elastic.viscosity = 50.0;
  elastic.friction = 0.0;
  Press press;
  press.setup.spacing = 0.003;
  press.setup.tool = PressSetup::Tool::sphere;
  press.setup.radius = 0.012;
  press.curve = {{0.0, 0.0, 0.0}, {0.3, 0.003, 1.0}, {0.6, 0.003, 1.0}};
  press.windows = windowsOf(press.curve);
  const double hertz = 16.0 / 3.0 * elastic.stiffness * std::sqrt(0.012) * std::pow(0.003, 1.5);
  EXPECT_NEAR(press.forces(elastic).back(), hertz, 0.3 * hertz);

  press.setup.tool = PressSetup::Tool::plate;
  press.setup.sample.kind = scene::Shape::Kind::cylinder;
  press.setup.sample.size = {0.015, 0.015, 0.03};
  press.curve = {{0.0, 0.0, 0.0}, {0.3, 0.0006, 1.0}, {0.6, 0.0006, 1.0}};
  const double bar = 3.0 * elastic.stiffness * M_PI * 0.015 * 0.015 * 0.0006 / 0.03;
  EXPECT_NEAR(press.forces(elastic).back(), bar, 0.15 * bar);
}

}  // namespace
}  // namespace tactile_clay::tools::fit_test
