#include "rviz_plugins/rig_state_display.h"

#include <rviz/display_context.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>

#include <QFontMetrics>
#include <QPainter>
#include <algorithm>
#include <cstdio>
#include <pluginlib/class_list_macros.hpp>

namespace tactile_clay::rviz_plugins {
namespace {

constexpr float drawn_every = 0.25f;  // s; numbers that change faster cannot be read
constexpr double max_age = 2.0;       // s, without a message
constexpr double real_time = 0.97;    // real-time factor from which the clay keeps up
constexpr int margin = 12, gap = 6;   // pixels

const QColor colors[] = {QColor(40, 140, 70), QColor(210, 120, 0), QColor(140, 140, 140)};

std::string text(const char* format, double number) {
  char line[96];
  std::snprintf(line, sizeof line, format, number);
  return line;
}

}  // namespace

RigStateDisplay::RigStateDisplay() {
  clay_topic_ = new rviz::RosTopicProperty(
      "Clay", "clay/status",
      QString::fromStdString(ros::message_traits::datatype<tactile_clay::ClayStatus>()),
      "Topic with the state of the clay (tactile_clay/ClayStatus).", this, SLOT(subscribe()));
  array_topic_ = new rviz::RosTopicProperty(
      "Array", "array/state",
      QString::fromStdString(ros::message_traits::datatype<tactile_clay::ArrayState>()),
      "Topic with the state of the array (tactile_clay/ArrayState).", this, SLOT(subscribe()));
  size_ = new rviz::IntProperty("Text size", 15, "Height of the text, pixels.", this);
  size_->setMin(8);
  size_->setMax(60);
}

RigStateDisplay::~RigStateDisplay() = default;

void RigStateDisplay::onInitialize() {
  static int count = 0;
  overlay_ = std::make_unique<Overlay>("tactile_clay rig state " + std::to_string(count++));
  overlay_->place(margin, -margin);
}

void RigStateDisplay::onEnable() {
  overlay_->show(true);
  subscribe();
}

void RigStateDisplay::onDisable() {
  overlay_->show(false);
  clay_subscriber_.shutdown();
  array_subscriber_.shutdown();
}

void RigStateDisplay::reset() {
  Display::reset();
  clay_.reset();
  array_.reset();
  drawn_.clear();
}

void RigStateDisplay::subscribe() {
  if (!isEnabled()) return;
  clay_.reset();
  array_.reset();
  const auto now = [] { return ros::SteadyTime::now(); };
  try {
    clay_subscriber_ = update_nh_.subscribe<tactile_clay::ClayStatus>(
        clay_topic_->getTopicStd(), 1, [this, now](const tactile_clay::ClayStatus::ConstPtr& status) {
          clay_ = status;
          clay_came_ = now();
        });
    array_subscriber_ = update_nh_.subscribe<tactile_clay::ArrayState>(
        array_topic_->getTopicStd(), 1, [this, now](const tactile_clay::ArrayState::ConstPtr& state) {
          array_ = state;
          array_came_ = now();
        });
    setStatus(rviz::StatusProperty::Ok, "Topics", "subscribed");
  } catch (const ros::Exception& error) {
    setStatus(rviz::StatusProperty::Error, "Topics", error.what());
  }
}

std::vector<RigStateDisplay::Line> RigStateDisplay::lines() const {
  const ros::SteadyTime now = ros::SteadyTime::now();
  std::vector<Line> lines;
  if (!clay_ || (now - clay_came_).toSec() > max_age) {
    lines.push_back({"clay: no news", 2});
  } else {
    const bool late = clay_->real_time_factor > 0.0f && clay_->real_time_factor < real_time;
    lines.push_back({"clay: " + std::to_string(clay_->particles) + " particles, " +
                         text("%.2f of real time", clay_->real_time_factor),
                     late ? 1 : 0});
  }
  if (!array_ || (now - array_came_).toSec() > max_age) {
    lines.push_back({"array: no news", 2});
  } else {
    if (array_->emitting)
      lines.push_back({"array (" + array_->device + "): sounds", 0});
    else
      lines.push_back({"array (" + array_->device + "): silent, " + array_->silent_reason, 1});
    lines.push_back({text("hand to array: %.0f ms", 1e3 * static_cast<double>(array_->latency)), 0});
  }
  return lines;
}

void RigStateDisplay::update(float wall_dt, float) {
  since_drawn_ += wall_dt;
  if (since_drawn_ < drawn_every) return;
  since_drawn_ = 0.0f;
  const std::vector<Line> all = lines();
  std::string what = std::to_string(size_->getInt());
  for (const Line& line : all) what += "\n" + std::to_string(line.level) + line.text;
  if (what == drawn_) return;
  drawn_ = what;
  QFont font;
  font.setPixelSize(size_->getInt());
  const QFontMetrics metrics(font);
  const int row = metrics.height() + gap / 2, dot = size_->getInt() / 2;
  int width = 0;
  for (const Line& line : all)
    width = std::max(width, metrics.boundingRect(QString::fromStdString(line.text)).width());
  width += dot + 5 * gap;
  const int height = static_cast<int>(all.size()) * row + 2 * gap;
  overlay_->paint(width, height, [&](QPainter& painter) {
    painter.setPen(Qt::NoPen);
    painter.setBrush(QColor(255, 255, 255, 205));
    painter.drawRoundedRect(0, 0, width, height, gap, gap);
    painter.setFont(font);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const int y = gap + static_cast<int>(k) * row;
      painter.setPen(Qt::NoPen);
      painter.setBrush(colors[all[k].level]);
      painter.drawEllipse(2 * gap - dot / 2, y + (row - dot) / 2, dot, dot);
      painter.setPen(QColor(30, 30, 30));
      painter.drawText(2 * gap + dot + gap / 2, y + metrics.ascent(), QString::fromStdString(all[k].text));
    }
  });
  context_->queueRender();
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::RigStateDisplay, rviz::Display)
