#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// One field of a PointCloud2, read from wherever its message puts it.
template <typename T>
class Column {
 public:
  Column(const sensor_msgs::PointCloud2& cloud, std::size_t offset) : cloud_(&cloud), offset_(offset) {}

  T operator[](std::size_t i) const {
    T value;
    std::memcpy(&value, &cloud_->data[i * cloud_->point_step + offset_], sizeof(T));
    return value;
  }

 private:
  const sensor_msgs::PointCloud2* cloud_;
  std::size_t offset_;
};

/// Number of points.
/// @throws std::runtime_error where the message's sizes contradict each other
std::size_t pointCount(const sensor_msgs::PointCloud2& cloud);

bool hasField(const sensor_msgs::PointCloud2& cloud, const std::string& name);

/// Whether `column` gives a field of that name and type.
template <typename T>
bool hasColumn(const sensor_msgs::PointCloud2& cloud, const std::string& name);

/// Field `name` of type float or std::uint32_t.
/// @throws std::runtime_error naming a field that is missing or of other type
template <typename T>
Column<T> column(const sensor_msgs::PointCloud2& cloud, const std::string& name);

/// Builds a cloud, point by point, of fields of four bytes.
class CloudWriter {
 public:
  /// @param fields names, separated by spaces; a name that ends in `:u` is of type uint32, all others float32
  CloudWriter(const std_msgs::Header& header, const std::string& fields, std::size_t points);

  CloudWriter& operator<<(float value) { return put(value); }
  CloudWriter& operator<<(std::uint32_t value) { return put(value); }
  template <typename Vector>
  CloudWriter& vector(const Vector& v) {
    return *this << v[0] << v[1] << v[2];
  }

  /// The cloud, once all points were written.
  /// @throws std::logic_error if there were more or fewer
  sensor_msgs::PointCloud2Ptr finish();

 private:
  template <typename T>
  CloudWriter& put(T value) {
    static_assert(sizeof(T) == 4);
    std::memcpy(&cloud_->data.at(at_ + 3) - 3, &value, 4);
    at_ += 4;
    return *this;
  }

  sensor_msgs::PointCloud2Ptr cloud_;
  std::size_t at_ = 0;
};

}  // namespace tactile_clay::nodes
