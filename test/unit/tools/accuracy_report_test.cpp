#include "tools/accuracy_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

namespace tactile_clay::tools::accuracy_report_test {
namespace {

TEST(AccuracyReport, SolversHaveTheNamesByWhichTheyAreChosen) {
  for (const clay::Method method : {clay::Method::minimise, clay::Method::paper})
    EXPECT_EQ(clay::methodNamed(nameOf(method)), method);
}

Errors errors(double displacement, double height, double force) {
  Errors e;
  e.displacement = displacement;
  e.height = height;
  e.force = force;
  return e;
}

TEST(Convergence, IsATenthOfTheSmallestErrorOfEachKindOrTwiceWhatAMicrometreDoes) {
  const Doubt doubt{errors(0.03, -0.002, 0.02), errors(0.01, 0.0005, 0.015)};
  EXPECT_EQ(convergence(doubt, {errors(0.31, -0.05, 0.1), errors(0.4, 0.01, 0.2)}),
            "- displacement, spacings: half the step 0.03, 1 µm aside 0.01, smallest error 0.31: converged\n"
            "- height, %: half the step 0.2, 1 µm aside 0.05, smallest error 1: not converged\n"
            "- force, %: half the step 2, 1 µm aside 1.5, smallest error 10: converged within chance\n");
}

bool converged(double change, double smallest, double aside = 0.0) {
  const std::string verdict =
      convergence({errors(change, NAN, NAN), errors(aside, 0.0, 0.0)}, {errors(smallest, 0.0, 0.0)});
  EXPECT_NE(verdict.find("converged"), std::string::npos) << verdict;
  return verdict.find("not converged") == std::string::npos;
}

TEST(Convergence, HoldsUpToATenth) {
  EXPECT_TRUE(converged(0.0, 0.0));
  EXPECT_TRUE(converged(0.099, 1.0));
  EXPECT_TRUE(converged(-0.099, 1.0));
  EXPECT_FALSE(converged(0.101, 1.0));
  EXPECT_FALSE(converged(-0.101, 1.0));
  EXPECT_FALSE(converged(0.101, -1.0));
}

TEST(Convergence, HoldsUpToTwiceWhatAMicrometreDoes) {
  EXPECT_TRUE(converged(0.199, 1.0, 0.1));
  EXPECT_TRUE(converged(-0.199, 1.0, -0.1));
  EXPECT_FALSE(converged(0.201, 1.0, 0.1));
}

TEST(Convergence, SaysNothingOfAForceThatIsNotThere) {
  const std::string verdict =
      convergence({errors(0.01, 0.01, NAN), errors(0.01, 0.01, 0.0)}, {errors(0.1, 0.1, NAN)});
  EXPECT_NE(verdict.find("- height"), std::string::npos);
  EXPECT_EQ(verdict.find("- force"), std::string::npos);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> found;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) found.push_back(cell);
  return found;
}

TEST(AccuracyCsv, EveryColumnHoldsWhatItsNameSays) {
  Played played{"incline", "none", 0.005, 512, 1.2};
  played.material = "putty";
  played.model = "soft";
  Row row{"setting", {4, 8, clay::Method::paper}, {}, {0.5, -0.125, NAN, 0.25}};
  row.outcome.ms = {20.0, 10.0, 30.0};
  row.outcome.height = 0.04;
  row.outcome.mean_force = 3.0;
  row.outcome.density = 0.01;
  row.outcome.densest = 0.02;
  row.outcome.volume_change = -0.03;
  row.skin = 0.008;
  row.rendering = "points:4";
  row.rendered = {0.375, 1.5};
  std::ostringstream head, line;
  writeCsvHead(head);
  writeCsvRow(line, played, row);
  ASSERT_EQ(head.str().back(), '\n');
  ASSERT_EQ(line.str().back(), '\n');
  const auto names = cells(head.str().substr(0, head.str().size() - 1)),
             values = cells(line.str().substr(0, line.str().size() - 1));
  ASSERT_EQ(names.size(), values.size());
  std::map<std::string, std::string> told;
  for (std::size_t k = 0; k < names.size(); ++k) told[names[k]] = values[k];
  const std::map<std::string, std::string> expected = {{"scene", "incline"},
                                                       {"hands", "none"},
                                                       {"spacing_m", "0.005"},
                                                       {"particles", "512"},
                                                       {"role", "setting"},
                                                       {"solver", "paper"},
                                                       {"substeps", "4"},
                                                       {"iterations", "8"},
                                                       {"ms_frame_median", "20"},
                                                       {"ms_frame_p99", "30"},
                                                       {"ms_step_median", "5"},
                                                       {"ms_step_p99", "7.5"},
                                                       {"displacement_rms_spacings", "0.5"},
                                                       {"height_m", "0.04"},
                                                       {"height_error", "-0.125"},
                                                       {"force_error", "nan"},
                                                       {"mean_force_N", "3"},
                                                       {"mean_force_error", "0.25"},
                                                       {"density_error_mean", "0.01"},
                                                       {"density_error_max", "0.02"},
                                                       {"volume_change", "-0.03"},
                                                       {"material", "putty"},
                                                       {"hand", "soft"},
                                                       {"skin_m", "0.008"},
                                                       {"rendering", "points:4"},
                                                       {"pressure_error", "0.375"},
                                                       {"ms_rendering", "1.5"}};
  EXPECT_EQ(told, expected);
}

}  // namespace
}  // namespace tactile_clay::tools::accuracy_report_test
