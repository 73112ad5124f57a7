#include "files/apart.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <new>
#include <vector>

#include "support/error_of.h"

namespace tactile_clay::files::apart_test {
namespace {

std::string errorOfApart(const std::function<std::string()>& work, const Bounds& bounds = {}) {
  return errorOf([&] { runApart(work, bounds); });
}

TEST(Apart, WhatIsFoundComesBack) {
  const std::string all(3 * mebibyte, '\0');
  EXPECT_EQ(runApart([&] { return all + "end"; }), all + "end");
  EXPECT_EQ(runApart([] { return std::string(); }), "");
}

TEST(Apart, WordsOfErrorsComeBack) {
  EXPECT_EQ(errorOfApart([]() -> std::string { throw std::runtime_error("has no head"); }), "has no head");
}

TEST(Apart, NothingElseChanges) {
  int here = 1;
  runApart([&] { return std::to_string(++here); });
  EXPECT_EQ(here, 1);
}

TEST(Apart, ACrashIsAnError) {
  const auto crash = []() -> std::string {
    std::raise(SIGSEGV);
    return "";
  };
  EXPECT_EQ(errorOfApart(crash), "crashes its reader (Segmentation fault), expected a sound file");
  EXPECT_EQ(errorOfApart([]() -> std::string { ::_exit(3); }), "ends its reader, expected a sound file");
}

TEST(Apart, NothingLastsForEver) {
  Bounds bounds;
  bounds.time = std::chrono::seconds(1);
  const auto work = []() -> std::string {
    for (volatile unsigned k = 0;; k = k + 1) {
    }
  };
  EXPECT_EQ(errorOfApart(work, bounds), "takes its reader more than 1 s, expected less");
  const auto wait = []() -> std::string {
    ::pause();
    return "";
  };
  EXPECT_EQ(errorOfApart(wait, bounds), "takes its reader more than 1 s, expected less");
}

#ifndef __SANITIZE_ADDRESS__
TEST(Apart, NothingTakesAllMemory) {
  Bounds bounds;
  bounds.memory = 64 * mebibyte;
  const auto grow = []() -> std::string {
    std::vector<std::string> all;
    while (true) all.emplace_back(mebibyte, 'x');
  };
  EXPECT_EQ(errorOfApart(grow, bounds), "takes its reader more than 64 MiB of memory, expected less");
}
#endif

}  // namespace
}  // namespace tactile_clay::files::apart_test
