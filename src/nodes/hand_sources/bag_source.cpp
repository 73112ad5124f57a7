#include "nodes/hand_sources/bag_source.h"

#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>

#include "files/input_file.h"
#include "nodes/conversions.h"

namespace tactile_clay::nodes {

void BagSource::open(const hand::SourceOptions& options) {
  file_ = options.file;
  loop_ = options.loop;
  if (file_.empty()) throw std::runtime_error("hands from a bag: expected its file name in 'file'");
  files::requireInput(file_, files::most::recording);
  try {
    bag_.open(file_, rosbag::bagmode::Read);
    // A bag holds the name as it was resolved, with a slash in front.
    const std::string topic = options.topic.empty() ? "hands/tracked" : options.topic;
    const std::string absolute = topic[0] == '/' ? topic : "/" + topic;
    const rosbag::TopicQuery wanted(std::vector<std::string>{topic, absolute});
    view_ = std::make_unique<rosbag::View>(bag_, wanted);
    if (view_->size() == 0)
      throw std::runtime_error(file_ + ": no message on topic '" + topic + "' in this bag");
    for (const rosbag::ConnectionInfo* connection : view_->getConnections())
      if (connection->datatype != ros::message_traits::DataType<TrackedHands>::value() ||
          connection->md5sum != ros::message_traits::MD5Sum<TrackedHands>::value())
        throw std::runtime_error(file_ + ": topic '" + topic + "' is of type " + connection->datatype + " (" +
                                 connection->md5sum + "), expected tactile_clay/TrackedHands (" +
                                 ros::message_traits::MD5Sum<TrackedHands>::value() + ")");
    next_ = view_->begin();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(file_ + ": not a readable bag: " + error.what());
  }
}

hand::HandSource::Read BagSource::read(hand::TrackedFrame& frame, std::chrono::milliseconds) {
  try {
    if (next_ == view_->end()) {
      if (!loop_) return Read::ended;
      stamps_.rewind();
      next_ = view_->begin();
    }
    const auto message = next_->instantiate<TrackedHands>();
    if (!message) throw std::runtime_error(file_ + ": a message that is no tactile_clay/TrackedHands");
    frame = toCore(*message);
    if (message->header.stamp.isZero()) frame.stamp = toCore(next_->getTime());
    ++next_;
    frame.stamp = stamps_(frame.stamp);
    return Read::frame;
  } catch (const ros::Exception& error) {
    throw std::runtime_error(file_ + ": damaged bag: " + error.what());
  }
}

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::BagSource, tactile_clay::hand::HandSource)
