#include "rviz_plugins/sound_bar.h"

#include <QFont>
#include <QFontMetrics>
#include <QPainter>
#include <algorithm>
#include <array>

namespace tactile_clay::rviz_plugins {
namespace {

/// Colours at equal distances from 0 to the full scale: dark to light, so that they can also be distinguished
/// in grey.
const std::array<Ogre::ColourValue, 5> stops = {
    Ogre::ColourValue(0.02f, 0.02f, 0.10f), Ogre::ColourValue(0.25f, 0.07f, 0.45f),
    Ogre::ColourValue(0.72f, 0.19f, 0.42f), Ogre::ColourValue(0.97f, 0.52f, 0.30f),
    Ogre::ColourValue(0.99f, 0.96f, 0.75f)};

}  // namespace

Ogre::ColourValue soundColor(float share) {
  const float at = static_cast<float>(stops.size() - 1) * std::clamp(share, 0.0f, 1.0f);
  const auto below = std::min(stops.size() - 2, static_cast<std::size_t>(at));
  const float t = at - static_cast<float>(below);
  return stops[below] * (1.0f - t) + stops[below + 1] * t;
}

void paintSoundBar(Overlay& bar, const QString& title, double top, double length) {
  constexpr int text = 13, numbers = 5, bar_width = 18, bar_height = 180, gap = 8;  // pixels
  QFont font;
  font.setPixelSize(text);
  const QFontMetrics metrics(font);
  const int width = metrics.boundingRect(title).width() + 3 * gap;
  const int height = bar_height + metrics.height() + 4 * gap;
  bar.paint(width, height, [&](QPainter& painter) {
    painter.setPen(Qt::NoPen);
    painter.setBrush(QColor(255, 255, 255, 205));
    painter.drawRoundedRect(0, 0, width, height, gap, gap);
    painter.setFont(font);
    painter.setPen(QColor(30, 30, 30));
    painter.drawText(gap, gap / 2 + metrics.ascent(), title);
    const int left = gap, below = metrics.height() + 2 * gap + bar_height;
    for (int y = 0; y < bar_height; ++y) {
      const Ogre::ColourValue color = soundColor(static_cast<float>(y) / bar_height);
      painter.fillRect(left, below - y - 1, bar_width, 1,
                       QColor::fromRgbF(static_cast<double>(color.r), static_cast<double>(color.g),
                                        static_cast<double>(color.b)));
    }
    for (int k = 0; k < numbers; ++k) {
      const double share = static_cast<double>(k) / (numbers - 1);
      painter.drawText(left + bar_width + gap,
                       below - static_cast<int>(share * bar_height) + metrics.ascent() / 2 - 1,
                       QString::number(top - length * (1.0 - share), 'f', 0));
    }
  });
}

}  // namespace tactile_clay::rviz_plugins
