#include "nodes/stamps.h"

#include <algorithm>

namespace tactile_clay::nodes {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint32_t second = 1'000'000'000;  // ns
constexpr nanoseconds last_stamp = nanoseconds(stamp_end) - nanoseconds(1);

}  // namespace

std::string faultOf(const ros::Time& stamp) {
  if (stamp.nsec >= second)
    return "stamp with " + std::to_string(stamp.nsec) + " ns, expected fewer than 10^9";
  if (std::chrono::seconds(stamp.sec) >= stamp_end)
    return "stamp of " + std::to_string(stamp.sec) + " s, expected less than 2^31 s";
  return "";
}

nanoseconds toCore(const ros::Time& stamp) {
  return std::min<nanoseconds>(std::chrono::seconds(stamp.sec) + nanoseconds(stamp.nsec), last_stamp);
}

ros::Time toRos(nanoseconds stamp) {
  const nanoseconds kept = std::clamp(stamp, nanoseconds(0), last_stamp);
  return {static_cast<std::uint32_t>(kept.count() / second),
          static_cast<std::uint32_t>(kept.count() % second)};
}

double secondsBetween(const ros::Time& from, const ros::Time& to) {
  return std::chrono::duration<double>(toCore(to) - toCore(from)).count();
}

bool isOfTheFuture(const ros::Time& stamp, const ros::Time& now) {
  return !now.isZero() && secondsBetween(now, stamp) > 1.0;
}

}  // namespace tactile_clay::nodes
