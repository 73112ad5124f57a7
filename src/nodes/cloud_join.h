#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <deque>
#include <optional>
#include <utility>

namespace tactile_clay::nodes {

/// Joins skins and contacts of the same stamp, whichever comes first. What has waited longest makes room for
/// what is new: a join that keeps the latest stamps, as message_filters has it, would be stopped for good by
/// one burst of stamps in the future.
class CloudJoin {
 public:
  using Cloud = sensor_msgs::PointCloud2::ConstPtr;
  using Pair = std::pair<Cloud, Cloud>;  // skin, contacts

  /// @return the pair that is now complete; what came before it is forgotten
  std::optional<Pair> addSkin(const Cloud& skin) { return add(skin, &Pair::first); }
  std::optional<Pair> addContacts(const Cloud& contacts) { return add(contacts, &Pair::second); }

 private:
  struct Waiting {
    ros::Time stamp;
    Pair clouds;
  };

  std::optional<Pair> add(const Cloud& cloud, Cloud Pair::*side) {
    std::size_t at = 0;
    while (at < waiting_.size() && waiting_[at].stamp != cloud->header.stamp) ++at;
    if (at == waiting_.size()) waiting_.push_back({cloud->header.stamp, {}});
    waiting_[at].clouds.*side = cloud;
    if (waiting_[at].clouds.first && waiting_[at].clouds.second) {
      Pair complete = std::move(waiting_[at].clouds);
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(at) + 1);
      return complete;
    }
    while (waiting_.size() > 1 && (waiting_.size() > max_waiting || bytes() > max_bytes))
      waiting_.pop_front();
    return std::nullopt;
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Waiting& one : waiting_)
      for (const Cloud& cloud : {one.clouds.first, one.clouds.second}) sum += cloud ? cloud->data.size() : 0;
    return sum;
  }

  static constexpr std::size_t max_waiting = 100;  // live, the clay skips skins
  static constexpr std::size_t max_bytes = 64U << 20U;

  std::deque<Waiting> waiting_;  // by arrival
};

}  // namespace tactile_clay::nodes
