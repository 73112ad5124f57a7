#pragma once

#include <QString>

class QLabel;

namespace tactile_clay::rviz_plugins {

/// What a line tells; its colour.
enum class News { good, bad, none };

/// Shows words in a label. A long text is cut, so that no line pushes others out of the panel; the tool tip
/// has all of it.
/// @param longest characters
void showLine(QLabel& line, const QString& words, News news, int longest = 80);

}  // namespace tactile_clay::rviz_plugins
