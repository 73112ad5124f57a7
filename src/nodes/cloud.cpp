#include "nodes/cloud.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <sstream>
#include <stdexcept>

namespace tactile_clay::nodes {
namespace {

using sensor_msgs::PointField;

template <typename T>
constexpr std::uint8_t type_of = std::is_same_v<T, float> ? PointField::FLOAT32 : PointField::UINT32;

template <typename T>
bool isColumn(const sensor_msgs::PointCloud2& cloud, const PointField& field, const std::string& name) {
  return field.name == name && field.datatype == type_of<T> &&
         std::size_t{field.offset} + 4 <= cloud.point_step;
}

}  // namespace

std::size_t pointCount(const sensor_msgs::PointCloud2& cloud) {
  const std::size_t points = std::size_t{cloud.width} * cloud.height, step = cloud.point_step;
  const bool gaps = cloud.height > 1 && cloud.row_step != step * cloud.width;
  // Compared by division, because a product of three numbers of 32 bits can wrap around.
  const bool fits = points == 0 || (step > 0 && cloud.data.size() / step >= points);
  if (cloud.is_bigendian || gaps || !fits)
    throw std::runtime_error("cloud of " + std::to_string(points) + " points of " + std::to_string(step) +
                             " bytes: expected little-endian data of that size without gaps, got " +
                             std::to_string(cloud.data.size()) + " bytes");
  return points;
}

bool hasField(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [&](const PointField& field) { return field.name == name; });
}

template <typename T>
bool hasColumn(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [&](const PointField& field) { return isColumn<T>(cloud, field, name); });
}

template bool hasColumn<float>(const sensor_msgs::PointCloud2&, const std::string&);
template bool hasColumn<std::uint32_t>(const sensor_msgs::PointCloud2&, const std::string&);

template <typename T>
Column<T> column(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  for (const PointField& field : cloud.fields)
    if (isColumn<T>(cloud, field, name)) return {cloud, field.offset};
  throw std::runtime_error("cloud without field '" + name + "' of type " +
                           (std::is_same_v<T, float> ? "float32" : "uint32"));
}

template Column<float> column<float>(const sensor_msgs::PointCloud2&, const std::string&);
template Column<std::uint32_t> column<std::uint32_t>(const sensor_msgs::PointCloud2&, const std::string&);

CloudWriter::CloudWriter(const std_msgs::Header& header, const std::string& fields, std::size_t points)
    : cloud_(boost::make_shared<sensor_msgs::PointCloud2>()) {
  cloud_->header = header;
  std::istringstream names(fields);
  for (std::string name; names >> name;) {
    PointField field;
    const bool whole = name.size() > 2 && name.compare(name.size() - 2, 2, ":u") == 0;
    field.name = whole ? name.substr(0, name.size() - 2) : name;
    field.datatype = whole ? PointField::UINT32 : PointField::FLOAT32;
    field.offset = cloud_->point_step;
    field.count = 1;
    cloud_->fields.push_back(field);
    cloud_->point_step += 4;
  }
  cloud_->height = 1;
  cloud_->width = static_cast<std::uint32_t>(points);
  cloud_->row_step = cloud_->point_step * cloud_->width;
  cloud_->is_dense = true;
  cloud_->data.resize(cloud_->row_step);
}

sensor_msgs::PointCloud2Ptr CloudWriter::finish() {
  if (at_ != cloud_->data.size()) throw std::logic_error("cloud written with other points than announced");
  return std::move(cloud_);
}

}  // namespace tactile_clay::nodes
