// The library picks AVX-512, AVX2 or plain code by the processor it runs on. Its results must not depend on
// this.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

std::vector<float> results();
std::vector<float> plainResults();

TEST(Processor, HasNoInfluenceOnTheResults) {
  const std::vector<float> here = results();
  const std::vector<float> plain = plainResults();
  ASSERT_GT(here.size(), 5000u);
  ASSERT_EQ(here.size(), plain.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    ASSERT_TRUE(std::isfinite(here[i]));
    ASSERT_EQ(here[i], plain[i]) << i;
  }
}
