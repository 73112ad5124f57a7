#include "tools/outcome_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "support/error_of.h"
#include "support/scratch_folder.h"

namespace tactile_clay::tools::outcome_file_test {
namespace {

Outcome someOutcome() {
  Outcome outcome;
  outcome.ms = {1.0 / 3.0, 2.5e-7};
  outcome.position.resize(2);
  outcome.position.set(0, {0.1F, -1.0F / 3.0F, 1e-9F});
  outcome.position.set(1, {3.4e5F, 0.0F, 7.0F});
  outcome.force = {Load::Constant(1.0 / 7.0), Load::Zero()};
  outcome.height = 0.04;
  outcome.mean_force = 2.0 / 3.0;
  outcome.density = 1e-4;
  outcome.densest = 0.2;
  outcome.volume_change = -0.01;
  outcome.rendered = {{1.0 / 3.0, 2.5}};
  return outcome;
}

class OutcomeFile : public ScratchFolder {
 protected:
  std::string file() const { return (folder / "one.outcome").string(); }
};

TEST_F(OutcomeFile, GivesBackEachBit) {
  const Outcome saved = someOutcome();
  saveOutcome(file(), "key", saved);
  const std::optional<Outcome> loaded = loadOutcome(file(), "key");
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->ms, saved.ms);
  ASSERT_EQ(loaded->position.size(), saved.position.size());
  for (std::size_t i = 0; i < saved.position.size(); ++i)
    EXPECT_EQ(loaded->position.at(i), saved.position.at(i)) << i;
  EXPECT_EQ(loaded->force, saved.force);
  EXPECT_EQ(loaded->height, saved.height);
  EXPECT_EQ(loaded->mean_force, saved.mean_force);
  EXPECT_EQ(loaded->density, saved.density);
  EXPECT_EQ(loaded->densest, saved.densest);
  EXPECT_EQ(loaded->volume_change, saved.volume_change);
  ASSERT_EQ(loaded->rendered.size(), 1U);
  EXPECT_EQ(loaded->rendered[0].error, saved.rendered[0].error);
  EXPECT_EQ(loaded->rendered[0].ms, saved.rendered[0].ms);
}

TEST_F(OutcomeFile, OfAnotherKeyOrNoneIsNone) {
  EXPECT_FALSE(loadOutcome(file(), "key"));
  saveOutcome(file(), "key", someOutcome());
  EXPECT_FALSE(loadOutcome(file(), "another key"));
}

TEST_F(OutcomeFile, BrokenOffIsOneLine) {
  saveOutcome(file(), "key", someOutcome());
  std::ifstream in(file());
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::ofstream(file()) << text.substr(0, text.size() - 5);
  EXPECT_NE(errorOf([&] { loadOutcome(file(), "key"); }).find("one.outcome' is incomplete: expected 'end'"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::tools::outcome_file_test
